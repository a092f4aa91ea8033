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

// Tolerance: of 20,000 points in eight lattices few lie so close to a border that single precision
// decides.
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

// Reference: one measured point, a quarter of a leaf from a border of each of the two lattices
// along an axis. Up to a quarter away one shares its leaf in both, up to three quarters in one.
TEST(OctreeScoreTest, IsTheMeanOverLatticesHalfALeafApart) {
  const std::vector<Vector3d> one{{0.123, -0.456, 0.789}};
  const auto score = [&](const Vector3d& leaves_away) {
    const std::vector<Vector3d> asked{one[0] + 0.01 * leaves_away};
    return OctreeScore(one, asked, 0.01);
  };
  EXPECT_EQ(score({0.2, -0.2, 0.2}), 1);
  EXPECT_EQ(score({0.3, 0, 0}), 0.5);
  EXPECT_EQ(score({0, -0.7, 0}), 0.5);
  EXPECT_EQ(score({0.3, -0.7, 0}), 0.25);
  EXPECT_EQ(score({0.5, 0.5, -0.5}), 0.125);
  EXPECT_EQ(score({0, 0, 0.8}), 0);
}

// A flat face without noise against the same with 2 mm.
TEST(OctreeScoreTest, IsTheSameWhereverTheFrameLies) {
  std::mt19937 generator(6);
  std::normal_distribution<double> noise(0, 0.002);
  auto measured = RandomPoints(20000, 0.1, 4), simulated = RandomPoints(5000, 0.1, 5);
  for (auto& p : measured) p.z() = 0;
  for (auto& p : simulated) p.z() = noise(generator);
  const double score = OctreeScore(measured, simulated, 0.01);
  EXPECT_GT(score, 0.8);
  const Vector3d way(0.0031, -0.0072, 0.005);
  for (auto& p : measured) p += way;
  for (auto& p : simulated) p += way;
  // Hardly one of 5000 points in eight lattices lies so close to a border that rounding moves it.
  EXPECT_NEAR(OctreeScore(measured, simulated, 0.01), score, 1e-4);
}

}  // namespace
}  // namespace palpate::study
