#include "slave/mechanics/linear/node_vector.h"

#include <algorithm>
#include <cmath>

#include "slave/mechanics/linear/lanes.h"

namespace palpate::fem {
namespace {

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
  for (std::size_t i = 0; i < count; ++i) Store4(y[i].v) += alpha * Load4(x[i].v);
}

PALPATE_DISPATCHED void ScaleAndAddTo(double beta, const NodeValue* x, NodeValue* y,
                                      std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    Store4(y[i].v) = Load4(x[i].v) + beta * Load4(y[i].v);
  }
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

void SetZero(NodeVector& x) noexcept {
  std::fill(x.begin(), x.end(), NodeValue{});
}

}  // namespace palpate::fem
