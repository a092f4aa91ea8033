#include "slave/mechanics/linear/block_matrix.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/mechanics/linear/lanes.h"
#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

PALPATE_INLINE Double4 ThreeOf(const Double4& v) {
  return Double4{v[0], v[1], v[2], 0};
}

// Reads one number beyond each block and ignores it.
PALPATE_DISPATCHED void MultiplyBlocks(const int* begin, const int* column, const double* values,
                                       int rows, const NodeValue* x, NodeValue* y) {
  for (int i = 0; i < rows; ++i) {
    Double4 sum0{}, sum1{}, sum2{};
    for (int k = begin[i]; k < begin[i + 1]; ++k) {
      const double* block = values + 9 * static_cast<std::size_t>(k);
      const double* xj = x[column[k]].v;
      sum0 += Load4(block) * xj[0];
      sum1 += Load4(block + 3) * xj[1];
      sum2 += Load4(block + 6) * xj[2];
    }
    Store4(y[i].v, ThreeOf(sum0 + sum1 + sum2));
  }
}

PALPATE_DISPATCHED void MultiplyBlocksByFour(const int* begin, const int* column,
                                             const double* values, int rows,
                                             const NodeValue* const* x, NodeValue* const* y) {
  for (int i = 0; i < rows; ++i) {
    Double4 even[4]{}, odd[4]{};
    for (int k = begin[i]; k < begin[i + 1]; ++k) {
      const double* block = values + 9 * static_cast<std::size_t>(k);
      const Double4 b0 = Load4(block), b1 = Load4(block + 3), b2 = Load4(block + 6);
      for (int n = 0; n < 4; ++n) {
        const double* xj = x[n][column[k]].v;
        even[n] += b0 * xj[0];
        odd[n] += b1 * xj[1];
        even[n] += b2 * xj[2];
      }
    }
    for (int n = 0; n < 4; ++n) Store4(y[n][i].v, ThreeOf(even[n] + odd[n]));
  }
}

PALPATE_DISPATCHED void MultiplyWeights(const int* begin, const int* column, const double* weights,
                                        int rows, const NodeValue* x, NodeValue* y) {
  for (int i = 0; i < rows; ++i) {
    Double4 sum{};
    for (int k = begin[i]; k < begin[i + 1]; ++k) sum += weights[k] * Load4(x[column[k]].v);
    Store4(y[i].v, sum);
  }
}

PALPATE_DISPATCHED double DotOf(const NodeValue* a, const NodeValue* b, std::size_t count) {
  Double4 sum0{}, sum1{}, sum2{}, sum3{};
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    sum0 += Load4(a[i].v) * Load4(b[i].v);
    sum1 += Load4(a[i + 1].v) * Load4(b[i + 1].v);
    sum2 += Load4(a[i + 2].v) * Load4(b[i + 2].v);
    sum3 += Load4(a[i + 3].v) * Load4(b[i + 3].v);
  }
  for (; i < count; ++i) sum0 += Load4(a[i].v) * Load4(b[i].v);
  const Double4 sum = (sum0 + sum1) + (sum2 + sum3);
  return sum[0] + sum[1] + sum[2];
}

PALPATE_DISPATCHED void AddTo(double alpha, const NodeValue* x, NodeValue* y, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) Store4(y[i].v, Load4(y[i].v) + alpha * Load4(x[i].v));
}

PALPATE_DISPATCHED void ScaleAndAddTo(double beta, const NodeValue* x, NodeValue* y,
                                      std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) Store4(y[i].v, Load4(x[i].v) + beta * Load4(y[i].v));
}

}  // namespace

double Dot(const NodeVector& a, const NodeVector& b) noexcept {
  return DotOf(a.data(), b.data(), a.size());
}

double Norm(const NodeVector& a) noexcept {
  return std::sqrt(Dot(a, a));
}

double LargestComponent(const NodeVector& a) noexcept {
  double largest = 0;
  for (const auto& node : a) {
    for (const double v : node.v) {
      if (!(std::abs(v) <= largest)) largest = std::abs(v);
    }
  }
  return largest;
}

void Add(double alpha, const NodeVector& x, NodeVector& y) noexcept {
  AddTo(alpha, x.data(), y.data(), y.size());
}

void ScaleAndAdd(double beta, const NodeVector& x, NodeVector& y) noexcept {
  ScaleAndAddTo(beta, x.data(), y.data(), y.size());
}

void Scale(double alpha, NodeVector& x) noexcept {
  for (auto& node : x) {
    for (double& v : node.v) v *= alpha;
  }
}

void SetZero(NodeVector& x) noexcept {
  std::fill(x.begin(), x.end(), NodeValue{});
}

int BlockPattern::Find(int row, int column) const {
  const auto columns = graph.of(row);
  const auto found = std::lower_bound(columns.begin(), columns.end(), column);
  if (found == columns.end() || *found != column) return -1;
  return graph.begin[Index(row)] + static_cast<int>(found - columns.begin());
}

BlockPattern MakePattern(NodeGraph graph) {
  BlockPattern pattern{std::move(graph), {}, {}};
  pattern.transpose.resize(Index(pattern.blocks()));
  for (int i = 0; i < pattern.rows(); ++i) {
    int k = pattern.graph.begin[Index(i)];
    for (const int j : pattern.graph.of(i)) pattern.transpose[Index(k++)] = pattern.Find(j, i);
    pattern.diagonal.push_back(pattern.Find(i, i));
  }
  return pattern;
}

BlockMatrix::BlockMatrix(const BlockPattern& pattern)
    : pattern_(&pattern), values_(9 * Index(pattern.blocks() + 1) + 1) {}

void BlockMatrix::Multiply(const NodeVector& x, NodeVector& y) const noexcept {
  const auto& graph = pattern_->graph;
  MultiplyBlocks(graph.begin.data(), graph.column.data(), values_.data(), graph.size(), x.data(),
                 y.data());
  std::fill(y.begin() + graph.size(), y.end(), NodeValue{});
}

void BlockMatrix::Multiply(const std::array<const NodeVector*, 4>& x,
                           const std::array<NodeVector*, 4>& y) const noexcept {
  const auto& graph = pattern_->graph;
  std::array<const NodeValue*, 4> from{};
  std::array<NodeValue*, 4> to{};
  for (std::size_t n = 0; n < 4; ++n) {
    from[n] = x[n]->data();
    to[n] = y[n]->data();
    std::fill(y[n]->begin() + graph.size(), y[n]->end(), NodeValue{});
  }
  MultiplyBlocksByFour(graph.begin.data(), graph.column.data(), values_.data(), graph.size(),
                       from.data(), to.data());
}

NodeValue BlockMatrix::Row(int row, const NodeVector& x) const noexcept {
  NodeValue sum;
  for (int k = pattern_->graph.begin[Index(row)]; k < pattern_->graph.begin[Index(row) + 1]; ++k) {
    const double* of = At(x, pattern_->graph.column[Index(k)]).v;
    for (std::size_t r = 0; r < 3; ++r) {
      sum.v[r] += block(k)[r] * of[0] + block(k)[r + 3] * of[1] + block(k)[r + 6] * of[2];
    }
  }
  return sum;
}

void MultiplyScalars(const BlockPattern& pattern, const std::vector<double>& scalars,
                     const NodeVector& x, NodeVector& y) noexcept {
  const auto& graph = pattern.graph;
  MultiplyWeights(graph.begin.data(), graph.column.data(), scalars.data(), graph.size(), x.data(),
                  y.data());
  std::fill(y.begin() + graph.size(), y.end(), NodeValue{});
}

}  // namespace palpate::fem
