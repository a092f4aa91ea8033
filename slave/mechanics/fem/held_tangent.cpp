#include "slave/mechanics/fem/held_tangent.h"

#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

constexpr double kPenalty = 1e4;  // of a held sum or a guided node, of the diagonal

}  // namespace

HeldTangent::HeldTangent(const BlockPattern& pattern)
    : pattern_(pattern), upper_(3 * pattern.rows(), 3 * pattern.rows()) {
  upper_.reserve(9L * (pattern.blocks() + pattern.rows()) / 2);
  for (int column = 0; column < upper_.cols(); ++column) {
    upper_.startVec(column);
    for (const int node : pattern.graph.of(column / 3)) {
      for (int row = 3 * node; row < 3 * node + 3 && row <= column; ++row) {
        upper_.insertBack(row, column) = 0;
      }
    }
  }
  upper_.finalize();
}

double& HeldTangent::At(int row, int k, int r, int c) noexcept {
  const int before = 3 * (k - pattern_.graph.begin[Index(row)]);
  return upper_.valuePtr()[upper_.outerIndexPtr()[3 * row + c] + before + r];
}

void HeldTangent::Fill(const BlockMatrix& matrix, double scale,
                       const HeldComponents& held) noexcept {
  for (int j = 0; j < pattern_.rows(); ++j) {
    const double* free_j = fem::At(held.free, j).v;
    for (int k = pattern_.graph.begin[Index(j)]; k <= pattern_.diagonal[Index(j)]; ++k) {
      const int i = pattern_.graph.column[Index(k)];
      const double* free_i = fem::At(held.free, i).v;
      const double* block = matrix.block(k);
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < (i == j ? c + 1 : 3); ++r) {
          const double value = scale * block[c + 3 * r] * free_i[r] * free_j[c];
          const bool diagonal = i == j && r == c;
          At(j, k, r, c) = !diagonal ? value : free_j[c] > 0 ? value * (1 + held.shift) : 1;
        }
      }
    }
  }
  for (const Guide& guide : held.guides) {
    const int k = pattern_.diagonal[Index(guide.row)];
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r <= c; ++r) {
        At(guide.row, k, r, c) += kPenalty * guide.normal[r] * guide.normal[c];
      }
    }
  }
  for (const auto& sum : held.sums) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        const int i = sum.node[a], j = sum.node[b];
        if (i > j || j >= pattern_.rows()) continue;  // a node without a free component has no row
        const int k = pattern_.Find(j, i);
        for (int c = 0; c < 3; ++c) {
          At(j, k, c, c) += kPenalty * sum.weight[a].v[c] * sum.weight[b].v[c];
        }
      }
    }
  }
}

std::size_t HeldTangent::memory_bytes() const {
  return static_cast<std::size_t>(upper_.nonZeros()) * (sizeof(double) + sizeof(int));
}

}  // namespace palpate::fem
