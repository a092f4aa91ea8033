// References: leaves counted as cells of a grid; closed forms.
#include <array>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "slave/study/shape/shape_score.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> RandomPoints(int n, double reach, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> place(-0.5 * reach, 0.5 * reach);
  std::vector<Vector3d> points;
  for (int i = 0; i < n; ++i) {
    points.emplace_back(place(generator), place(generator), place(generator));
  }
  return points;
}

using Cell = std::array<long, 3>;
Cell CellOf(const Vector3d& p, double edge) {
  return {std::lround(std::floor(p.x() / edge)), std::lround(std::floor(p.y() / edge)),
          std::lround(std::floor(p.z() / edge))};
}

// Tolerance: only few of 20,000 points in eight lattices are so close to a cell border that single
// precision matters.
TEST(OctreeScoreTest, IsTheShareInsideTheOccupiedCells) {
  constexpr double kLeaf = 0.01;
  const auto measured = RandomPoints(300, 0.3, 1), asked = RandomPoints(20000, 0.4, 2);
  Vector3d centroid = Vector3d::Zero();
  for (const auto& p : measured) centroid += p / 300;
  double expected = 0;
  for (int k = 0; k < 8; ++k) {
    const Vector3d side((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1);
    const Vector3d corner = centroid + 0.25 * kLeaf * side;
    std::set<Cell> occupied;
    for (const auto& p : measured) occupied.insert(CellOf(p - corner, kLeaf));
    for (const auto& p : asked) {
      expected += occupied.contains(CellOf(p - corner, kLeaf)) ? 1 / 160000.0 : 0;
    }
  }
  EXPECT_GT(expected, 0.002);
  EXPECT_NEAR(OctreeScore(measured, asked, kLeaf), expected, 2e-5);
}

}  // namespace
}  // namespace palpate::study
