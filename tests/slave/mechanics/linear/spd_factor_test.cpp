#include "slave/mechanics/linear/spd_factor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <thread>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

// Neighbours on a grid of side^3 nodes, each one beside, above and diagonally.
std::vector<std::vector<int>> Grid(int side) {
  std::vector<std::vector<int>> neighbours;
  const auto number = [&](int x, int y, int z) { return x + side * (y + side * z); };
  for (int i = 0; i < side * side * side; ++i) {
    auto& list = neighbours.emplace_back();
    const int x = i % side, y = i / side % side, z = i / side / side;
    for (int c = std::max(z - 1, 0); c <= std::min(z + 1, side - 1); ++c) {
      for (int b = std::max(y - 1, 0); b <= std::min(y + 1, side - 1); ++b) {
        for (int a = std::max(x - 1, 0); a <= std::min(x + 1, side - 1); ++a) {
          list.push_back(number(a, b, c));
        }
      }
    }
  }
  return neighbours;
}

// Symmetric with random entries between neighbours, upper triangle, nodes renumbered by `order`.
// `negative`: how many of the nodes have a negative diagonal. Diagonals dominate: the inertia is
// that of the diagonal (Sylvester's law and Gershgorin's circles).
Sparse Matrix(const std::vector<std::vector<int>>& neighbours, const std::vector<int>& order,
              int negative) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-1, 1);
  std::vector<int> rank(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    rank[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < static_cast<int>(order.size()); ++i) {
    for (const int j : neighbours[static_cast<std::size_t>(i)]) {
      if (j > i) continue;
      const int a = rank[static_cast<std::size_t>(i)], b = rank[static_cast<std::size_t>(j)];
      const double value = i != j ? side(random) : i < negative ? -30 : 30;
      entries.emplace_back(std::min(a, b), std::max(a, b), value);
    }
  }
  const auto n = static_cast<Eigen::Index>(order.size());
  Sparse matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

std::vector<int> AsNumbered(std::size_t nodes) {
  std::vector<int> order(nodes);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

MatrixXd Full(const Sparse& upper) {
  const MatrixXd half = upper;
  return half.selfadjointView<Eigen::Upper>();
}

TEST(SpdFactor, SolvesSeveralAtOnceAndRefusesTheIndefinite) {
  const auto grid = Grid(6);
  const Sparse matrix = Matrix(grid, AsNumbered(grid.size()), 0);
  SpdFactor factor(matrix.transpose());
  const MatrixXd B = MatrixXd::Random(matrix.cols(), 3);
  MatrixXd X = B;
  factor.Solve(X.data(), 3);
  EXPECT_LT((Full(matrix) * X - B).norm(), 1e-13 * B.norm());
  EXPECT_THROW(SpdFactor(Matrix(grid, AsNumbered(grid.size()), 1).transpose()),
               std::invalid_argument);
}

// A model is made while another one answers. Reference: one thread, bit for bit.
TEST(SpdFactor, ThreadsDoNotDisturbEachOther) {
  const auto grid = Grid(8);
  const Sparse lower = Matrix(grid, AsNumbered(grid.size()), 0).transpose();
  const auto solve = [&] {
    VectorXd x = VectorXd::Ones(lower.cols());
    SpdFactor(lower).Solve(x.data(), 1);
    return x;
  };
  const VectorXd expected = solve();
  std::vector<VectorXd> solved(4);
  {
    std::vector<std::jthread> threads;
    for (auto& x : solved) {
      threads.emplace_back([&] {
        for (int k = 0; k < 20; ++k) x = solve();
      });
    }
  }
  for (const auto& x : solved) EXPECT_EQ(x, expected);
}

}  // namespace
}  // namespace palpate
