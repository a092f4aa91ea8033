// Factors made at once and in parts, on the stiffness of springs between the nodes of a cubic grid.
#include "slave/mechanics/linear/sparse_cholesky.h"

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "tests/support/allocation_count.h"

namespace palpate::fem {
namespace {

using Eigen::Vector3d;
using Progress = SparseCholesky<double>::Progress;

NodeGraph GraphOf(const std::vector<Vector3d>& points) {
  NodeGraph graph{{0}, {}};
  for (const auto& p : points) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      if ((points[j] - p).lpNorm<Eigen::Infinity>() <= 1) {
        graph.column.push_back(static_cast<int>(j));
      }
    }
    graph.begin.push_back(static_cast<int>(graph.column.size()));
  }
  return graph;
}

// A cube whose separators have up to 81 nodes, in the order of elimination; springs of stiffness
// one, and an anchor of every node as stiff as 0.1.
struct Cube {
  EliminationTree tree;
  BlockPattern pattern;
  BlockMatrix matrix;
  HeldComponents held;

  Cube() : pattern(MakePattern(GraphOf(Ordered(&tree)))), matrix(pattern) {
    const std::vector<Vector3d> points = Ordered(&tree);
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Matrix3d sum = 0.1 * Eigen::Matrix3d::Identity();
      int k = pattern.graph.begin[i];
      for (const int j : pattern.graph.of(static_cast<int>(i))) {
        const Vector3d edge = points[static_cast<std::size_t>(j)] - points[i];
        Eigen::Map<Eigen::Matrix3d> block(matrix.block(k++));
        block.setZero();
        if (edge.isZero(0)) continue;
        block = -edge * edge.transpose() / edge.squaredNorm();
        sum -= block;
      }
      Eigen::Map<Eigen::Matrix3d>(matrix.block(pattern.diagonal[i])) = sum;
    }
    held.free.assign(points.size(), NodeValue{{1, 1, 1, 0}});
  }

  static std::vector<Vector3d> Ordered(EliminationTree* tree) {
    std::vector<Vector3d> points, ordered;
    for (int i = 0; i < 729; ++i) points.emplace_back(i % 9, i / 9 % 9, i / 81);
    *tree = Dissect(GraphOf(points), points);
    for (const int i : tree->order) ordered.push_back(points[static_cast<std::size_t>(i)]);
    return ordered;
  }
};

NodeVector Load(std::size_t nodes) {
  NodeVector r(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      r[i].v[c] = std::sin(0.7 * static_cast<double>(i) + 2.1 * static_cast<double>(c));
    }
  }
  return r;
}

// Reference: the equation itself. Tolerance: the condition number, about 260 (the largest
// eigenvalue is below twice that of the largest row, 26), times the rounding of doubles.
TEST(SparseCholeskyTest, SolvesTheEquation) {
  const Cube cube;
  SparseCholesky<double> factor(cube.tree, cube.pattern);
  factor.Reserve();
  ASSERT_TRUE(factor.Factor(cube.matrix, 1, cube.held, {}));
  const NodeVector r = Load(cube.held.free.size());
  NodeVector z(r.size()), Az(r.size());
  factor.Solve(r, z);
  cube.matrix.Multiply(z, Az);
  Add(-1, r, Az);
  EXPECT_LT(Norm(Az), 1e-13 * Norm(r));
}

// Reference: the same factor made at once, to the last bit. No part may be a large share: the
// largest front of such a cube, undivided, is a quarter of the work.
TEST(SparseCholeskyTest, AFactorMadeInPartsIsTheSame) {
  constexpr int kParts = 8;
  const Cube cube;
  SparseCholesky<double> at_once(cube.tree, cube.pattern), in_parts(cube.tree, cube.pattern);
  at_once.Reserve();
  in_parts.Reserve();
  ASSERT_TRUE(at_once.Factor(cube.matrix, 1, cube.held, {}));
  const long before = AllocationCount();
  for (int repeat = 0; repeat < 2; ++repeat) {  // the first one is given up
    in_parts.Begin();
    int parts = 1;
    while (in_parts.Continue(cube.matrix, 1, cube.held, in_parts.flops() / kParts) ==
           Progress::kMore) {
      ++parts;
      if (repeat == 0 && parts == 3) break;
    }
    if (repeat == 1) EXPECT_GE(parts, kParts - 2);
  }
  EXPECT_EQ(AllocationCount(), before);
  const NodeVector r = Load(cube.held.free.size());
  NodeVector one(r.size()), other(r.size());
  at_once.Solve(r, one);
  in_parts.Solve(r, other);
  Add(-1, one, other);
  EXPECT_EQ(LargestComponent(other), 0);
}

TEST(SparseCholeskyTest, AMatrixThatIsNotPositiveDefiniteFailsInItsPart) {
  Cube cube;
  cube.matrix.block(cube.pattern.diagonal[364])[0] = -1;
  SparseCholesky<double> factor(cube.tree, cube.pattern);
  factor.Reserve();
  factor.Begin();
  Progress progress = Progress::kMore;
  while (progress == Progress::kMore) {
    progress = factor.Continue(cube.matrix, 1, cube.held, factor.flops() / 8);
  }
  EXPECT_EQ(progress, Progress::kFailed);
}

// Reference: one product at a time; both sum up to 27 products of each kind in another order.
TEST(BlockMatrixTest, FourProductsAndSingleRowsAreThoseOfOneProduct) {
  const Cube cube;
  const std::size_t nodes = cube.held.free.size();
  std::vector<NodeVector> x(4, Load(nodes)), y(4, NodeVector(nodes + 1)), one(4, y[0]);
  for (std::size_t n = 1; n < 4; ++n) {
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t c = 0; c < 3; ++c) x[n][i].v[c] = x[n - 1][(i + 1) % nodes].v[c];
    }
  }
  for (auto& of : y) of.back().v[0] = 1;  // beyond the rows: becomes zero
  cube.matrix.Multiply({&x[0], &x[1], &x[2], &x[3]}, {&y[0], &y[1], &y[2], &y[3]});
  for (std::size_t n = 0; n < 4; ++n) {
    cube.matrix.Multiply(x[n], one[n]);
    for (std::size_t i = 0; i < nodes; ++i) {
      const NodeValue row = cube.matrix.Row(static_cast<int>(i), x[n]);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(y[n][i].v[c], one[n][i].v[c], 1e-13) << "vector " << n << ", node " << i;
        ASSERT_NEAR(row.v[c], one[n][i].v[c], 1e-13) << "vector " << n << ", node " << i;
      }
    }
    EXPECT_EQ(y[n].back().v[0], 0);
  }
}

}  // namespace
}  // namespace palpate::fem
