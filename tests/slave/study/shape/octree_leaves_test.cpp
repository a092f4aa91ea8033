// Reference: the Point Cloud Library's octree with the same leaves, told where they begin.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <pcl/octree/octree_search.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "slave/study/shape/shape_score.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> RandomPoints(int n, double reach, unsigned seed) {
  std::mt19937 generator(seed);
  // Whole twentieths of a millimetre and a bit: never on a leaf's face, where single precision and
  // double need not agree.
  std::uniform_int_distribution<int> steps(0, static_cast<int>(reach / 5e-5));
  std::vector<Vector3d> points;
  for (int i = 0; i < n; ++i) {
    Vector3d p;
    for (double& x : p) x = 5e-5 * steps(generator) - 0.5 * reach + 2.3e-5;
    points.push_back(p);
  }
  return points;
}

TEST(OctreeLeavesTest, LeavesAreThoseOfAnOctree) {
  constexpr double kLeaf = 0.01;
  const auto cloud = RandomPoints(300, 0.3, 1), asked = RandomPoints(20000, 0.4, 2);
  const OctreeLeaves leaves(cloud, kLeaf);
  auto input = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const auto& p : cloud) {
    const Eigen::Vector3f q = p.cast<float>();
    input->push_back({q.x(), q.y(), q.z()});
  }
  pcl::octree::OctreePointCloudSearch<pcl::PointXYZ> octree(kLeaf);
  octree.defineBoundingBox(-64 * kLeaf, -64 * kLeaf, -64 * kLeaf, 64 * kLeaf, 64 * kLeaf,
                           64 * kLeaf);
  octree.setInputCloud(input);
  octree.addPointsFromInputCloud();
  EXPECT_EQ(leaves.corners().size(), octree.getLeafCount());
  int inside = 0;
  for (const auto& p : asked) {
    const Eigen::Vector3f q = p.cast<float>();
    const bool expected = octree.isVoxelOccupiedAtPoint({q.x(), q.y(), q.z()});
    ASSERT_EQ(leaves.Contains(p), expected) << p.transpose();
    inside += expected ? 1 : 0;
  }
  EXPECT_DOUBLE_EQ(leaves.Share(asked), inside / 20000.0);
  EXPECT_GT(inside, 50);
}

TEST(OctreeLeavesTest, LeafHoldsItsLowerFacesAndNotItsUpperOnes) {
  const std::vector<Vector3d> one{{-0.005, 0.015, 0.025}};
  const OctreeLeaves leaves(one, 0.01);
  ASSERT_EQ(leaves.corners().size(), 1U);
  EXPECT_NEAR((leaves.corners()[0] - Vector3d(-0.01, 0.01, 0.02)).norm(), 0, 1e-15);
  EXPECT_TRUE(leaves.Contains({-0.01, 0.01, 0.02}));
  EXPECT_FALSE(leaves.Contains({0, 0.01, 0.02}));
  EXPECT_FALSE(leaves.Contains({-0.0101, 0.01, 0.02}));
}

TEST(OctreeLeavesTest, CloudScoresOneAgainstItselfAndZeroFarAway) {
  auto cloud = RandomPoints(1000, 0.2, 3);
  const OctreeLeaves leaves(cloud, 0.01);
  EXPECT_EQ(leaves.Share(cloud), 1);
  for (auto& p : cloud) p.x() += 0.5;
  EXPECT_EQ(leaves.Share(cloud), 0);
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

// A flat face without noise against the same with 2 mm: in one octree half of it is lost where the
// face lies on a border, and none amid the leaves.
TEST(OctreeScoreTest, IsTheSameWhereverTheFrameLies) {
  std::mt19937 generator(6);
  std::normal_distribution<double> noise(0, 0.002);
  auto measured = RandomPoints(20000, 0.1, 4), simulated = RandomPoints(5000, 0.1, 5);
  for (auto& p : measured) p.z() = 0;
  for (auto& p : simulated) p.z() = noise(generator);
  const double score = OctreeScore(measured, simulated, 0.01);
  EXPECT_LT(OctreeLeaves(measured).Share(simulated), 0.55);
  EXPECT_GT(score, 0.8);
  const Vector3d way(0.0031, -0.0072, 0.005);
  for (auto& p : measured) p += way;
  for (auto& p : simulated) p += way;
  EXPECT_GT(OctreeLeaves(measured).Share(simulated), 0.95);
  // Of 5000 points in eight lattices hardly one lies so close to a border that rounding moves it.
  EXPECT_NEAR(OctreeScore(measured, simulated, 0.01), score, 1e-4);
}

TEST(OctreeScoreTest, NothingHasNoScoreAndWhatIsNotFiniteMovesNoLattice) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Vector3d> cloud{{0.1, 0.2, 0.3}, {0.15, 0.2, 0.3}};
  EXPECT_EQ(OctreeScore(cloud, cloud, 0.01), 1);
  cloud.emplace_back(kNan, 0, 0);
  EXPECT_DOUBLE_EQ(OctreeScore(cloud, cloud, 0.01), 2.0 / 3);
  EXPECT_TRUE(std::isnan(OctreeScore({}, cloud, 0.01)));
  EXPECT_TRUE(std::isnan(OctreeScore(cloud, {}, 0.01)));
}

TEST(OctreeLeavesTest, WhatIsNotFiniteIsNowhereAndNothingHasNoScore) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const std::vector<Vector3d> bad{{kNan, 0, 0}, {0, kInfinite, 0}, {0, 0, -1e300}};
  const OctreeLeaves none(bad, 0.01);
  EXPECT_TRUE(none.corners().empty());
  EXPECT_EQ(none.Share(bad), 0);
  EXPECT_TRUE(std::isnan(none.Share({})));
  EXPECT_EQ(OctreeLeaves({}, 0.01).Share(RandomPoints(3, 1, 1)), 0);
  EXPECT_THROW(OctreeLeaves({}, 0), std::invalid_argument);
  EXPECT_THROW(OctreeLeaves({}, kNan), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::study
