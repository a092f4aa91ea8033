// The preconditioner of two grids, on the stiffness of springs along the edges of a regular grid.
#include "slave/mechanics/linear/two_grid.h"

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "slave/mechanics/linear/block_matrix.h"
#include "tests/support/allocation_count.h"

namespace palpate::fem {
namespace {

// Springs of stiffness one between all neighbours of a cubic grid, those along diagonals included,
// and an anchor of every node as stiff as `anchor`.
struct Springs {
  std::vector<Eigen::Vector3d> points;
  BlockPattern pattern;
  BlockMatrix matrix;
  NodeVector free;

  Springs(int side, double anchor)
      : points(Grid(side)), pattern(PatternOf(points)), matrix(pattern), free(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      // The bottom is fixed, and one side cannot move across.
      const bool bottom = points[i].z() == 0;
      for (std::size_t c = 0; c < 3; ++c) {
        free[i].v[c] = bottom || (c == 0 && points[i].x() == 0) ? 0 : 1;
      }
      Eigen::Matrix3d sum = anchor * Eigen::Matrix3d::Identity();
      int k = pattern.graph.begin[i];
      for (const int j : pattern.graph.of(static_cast<int>(i))) {
        const Eigen::Vector3d edge = points[static_cast<std::size_t>(j)] - points[i];
        Eigen::Map<Eigen::Matrix3d> block(matrix.block(k++));
        block.setZero();
        if (edge.isZero(0)) continue;
        block = -edge * edge.transpose() / edge.squaredNorm();
        sum -= block;
      }
      Eigen::Map<Eigen::Matrix3d>(matrix.block(pattern.diagonal[i])) = sum;
    }
  }

  static std::vector<Eigen::Vector3d> Grid(int side) {
    std::vector<Eigen::Vector3d> points;
    for (int z = 0; z < side; ++z) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) points.emplace_back(x, y, z);
      }
    }
    return points;
  }
  static BlockPattern PatternOf(const std::vector<Eigen::Vector3d>& points) {
    NodeGraph graph{{0}, {}};
    for (const auto& p : points) {
      for (std::size_t j = 0; j < points.size(); ++j) {
        if ((points[j] - p).lpNorm<Eigen::Infinity>() <= 1) {
          graph.column.push_back(static_cast<int>(j));
        }
      }
      graph.begin.push_back(static_cast<int>(graph.column.size()));
    }
    return MakePattern(std::move(graph));
  }
};

// Iterations of conjugate gradients until a random residual is a millionth.
int Iterations(const Springs& springs, TwoGrid* grids) {
  const std::size_t n = springs.points.size();
  NodeVector r(n), x(n), z(n), d(n), Ad(n);
  const Eigen::VectorXd random = Eigen::VectorXd::Random(static_cast<Eigen::Index>(3 * n));
  for (std::size_t i = 0; i < 3 * n; ++i) {
    r[i / 3].v[i % 3] = springs.free[i / 3].v[i % 3] * random[static_cast<Eigen::Index>(i)];
  }
  const double goal = 1e-6 * Norm(r);
  double rho = 0;
  int steps = 0;
  for (; Norm(r) > goal && steps < 1000; ++steps) {
    grids->Solve(r, z);
    const double next = Dot(r, z);
    EXPECT_GT(next, 0);
    steps == 0 ? (void)(d = z) : ScaleAndAdd(next / rho, z, d);
    rho = next;
    springs.matrix.Multiply(d, Ad);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t c = 0; c < 3; ++c) Ad[i].v[c] *= springs.free[i].v[c];
    }
    Add(-rho / Dot(d, Ad), Ad, r);
  }
  return steps;
}

// Purpose of a coarse grid: four times as many nodes along a side need few more iterations, and no
// more memory.
TEST(TwoGrid, NeedsAboutAsManyIterationsOnFinerGrids) {
  std::vector<int> iterations;
  for (const int side : {4, 8, 16}) {
    Springs springs(side, 0);
    TwoGrid grids(springs.points, springs.pattern);
    ASSERT_TRUE(grids.Factor(springs.matrix, springs.free));
    iterations.push_back(Iterations(springs, &grids));
    NodeVector r(springs.points.size()), z(springs.points.size());
    const long before = AllocationCount();
    ASSERT_TRUE(grids.Factor(springs.matrix, springs.free));
    grids.Solve(r, z);
    EXPECT_EQ(AllocationCount(), before);
  }
  EXPECT_LE(iterations.back(), 25);
  EXPECT_LE(iterations.back(), 2 * iterations.front());
}

// Law: the residual that iterations in single precision state is that of their solution, computed
// in double precision, to a hundredth down to 1e-3 of the right side (rounding leaves 1e-6); two
// rows that move in a plane only stay in it. No allocation.
TEST(TwoGrid, IterationsInSinglePrecisionLeaveWhatTheyState) {
  const Springs springs(12, 0.01);
  const std::size_t n = springs.points.size();
  const std::vector<Guide> guides{{1000, Eigen::Vector3d(1, 2, 2) / 3}, {1300, {0, 0.6, 0.8}}};
  const auto project = [&](NodeVector& x) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t c = 0; c < 3; ++c) x[i].v[c] *= springs.free[i].v[c];
    }
    for (const Guide& guide : guides) {
      Eigen::Map<Eigen::Vector3d> of(At(x, guide.row).v);
      of -= guide.normal.dot(of) * guide.normal;
    }
  };
  TwoGrid grids(springs.points, springs.pattern);
  ASSERT_TRUE(grids.Factor(springs.matrix, springs.free, guides));
  NodeVector b(n), r(n), x(n), Ax(n);
  const Eigen::VectorXd random = Eigen::VectorXd::Random(static_cast<Eigen::Index>(3 * n));
  for (std::size_t i = 0; i < 3 * n; ++i) b[i / 3].v[i % 3] = random[static_cast<Eigen::Index>(i)];
  project(b);
  r = b;
  const long before = AllocationCount();
  grids.Begin(r);
  int iterations = 0;
  for (; grids.residual() > 1e-3 * Norm(b) && iterations < 50; ++iterations) {
    ASSERT_GT(grids.Iterate(), 0);
  }
  const double stated = grids.residual();
  grids.End(r, x);
  EXPECT_EQ(AllocationCount(), before);
  EXPECT_GT(iterations, 2);
  EXPECT_LT(iterations, 25);
  NodeVector within = x;
  project(within);
  Add(-1, x, within);
  EXPECT_LT(Norm(within), 1e-6 * Norm(x));
  springs.matrix.Multiply(x, Ax);
  Scale(-1, Ax);
  Add(1, b, Ax);
  project(Ax);
  EXPECT_NEAR(Norm(Ax), stated, 1e-2 * stated);
  Add(-1, r, Ax);
  EXPECT_LT(Norm(Ax), 1e-2 * stated);
}

TEST(TwoGrid, RefusesWhatIsNotPositive) {
  Springs springs(4, 0);
  TwoGrid grids(springs.points, springs.pattern);
  EXPECT_FALSE(grids.Factor(Springs(4, -30).matrix, springs.free));
  springs.matrix.block(springs.pattern.diagonal[40])[0] = std::nan("");
  EXPECT_FALSE(grids.Factor(springs.matrix, springs.free));
}

}  // namespace
}  // namespace palpate::fem
