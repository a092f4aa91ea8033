// Green's functions between near nodes against whole solutions of the same body.
#include "slave/mechanics/fem/zone/near/near_green.h"

#include <numeric>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/zone/pressed_slab.h"

namespace palpate {
namespace {

using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::MatrixXd;
using Eigen::MatrixXf;

constexpr double kReach = 0.4;  // [larger sides]
// Share of the largest entry. Half a step of two bytes is 1.54e-5 of the largest of a tile, which
// other nodes of the group may make a little larger.
constexpr double kTwoBytes = 2e-5;
const std::size_t kEnough = 1 << 30;  // [bytes]

std::vector<int> NodesWithin(const NearGreen& green, const Vector3d& centre, double radius) {
  std::vector<int> nodes;
  for (std::size_t n = 0; n < green.positions().size(); ++n) {
    if ((green.positions()[n] - centre).norm() <= radius) nodes.push_back(static_cast<int>(n));
  }
  return nodes;
}

MatrixXd Expected(NearGreen& green, const std::vector<int>& to, const std::vector<int>& from) {
  MatrixXd unit = MatrixXd::Zero(3 * static_cast<int>(green.positions().size()),
                                 3 * static_cast<int>(from.size()));
  for (std::size_t j = 0; j < from.size(); ++j) {
    for (int c = 0; c < 3; ++c) unit(3 * from[j] + c, 3 * static_cast<int>(j) + c) = 1;
  }
  const MatrixXd u = green.Solve(unit);
  MatrixXd block(3 * static_cast<int>(to.size()), u.cols());
  for (std::size_t i = 0; i < to.size(); ++i) {
    block.middleRows<3>(3 * static_cast<int>(i)) = u.middleRows<3>(3 * to[i]);
  }
  return block;
}

TEST(NearGreen, GatheredBlocksAreTheWholeBodysSolutions) {
  const Slab slab(8, 0.4);
  NearGreen green(slab.mesh, slab.held, slab.nu, kEnough, {});
  const std::vector<int> from = NodesWithin(green, {0.5, 0.5, 0.5}, 0.15);
  const std::vector<int> to = NodesWithin(green, {0.5, 0.5, 0.45}, 0.2);
  ASSERT_TRUE(green.Prepare(from, kReach));
  MatrixXf got;
  ASSERT_TRUE(green.Gather(to, from, &got));
  const MatrixXd expected = Expected(green, to, from);
  EXPECT_LT((got.cast<double>() - expected).cwiseAbs().maxCoeff(),
            kTwoBytes * expected.cwiseAbs().maxCoeff());
  // Held nodes of the base neither move nor are moved.
  const std::vector<int> base = NodesWithin(green, {0.5, 0.5, 0}, 0.01);
  ASSERT_EQ(base.size(), 1U);
  ASSERT_TRUE(green.Prepare(base, kReach));
  green.Gather(to, base, &got);
  EXPECT_EQ(got.cwiseAbs().maxCoeff(), 0);
}

// Beyond reach the displacement is interpolated between anchors, so closely here that it is within
// a twentieth of the largest there; at anchors it is exact.
TEST(NearGreen, WhatIsBeyondReachIsInterpolatedBetweenAnchors) {
  const Slab slab(12, 0.4);
  NearGreen green(slab.mesh, slab.held, slab.nu, kEnough, {});
  const std::vector<int> from{NodesWithin(green, {0, 0, 0.5}, 0.01)};
  ASSERT_EQ(from.size(), 1U);
  const std::vector<int> far = NodesWithin(green, {1, 1, 0.5}, 0.5);
  std::vector<std::array<int, 2>> missed;
  MatrixXf got;
  EXPECT_FALSE(green.Gather(far, from, &got, &missed));
  EXPECT_EQ(missed.size(), far.size());
  EXPECT_EQ(got.cwiseAbs().maxCoeff(), 0);
  ASSERT_TRUE(green.Prepare(from, kReach));
  ASSERT_TRUE(green.Gather(far, from, &got));
  MatrixXd expected = Expected(green, far, from);
  EXPECT_LT((got.cast<double>() - expected).cwiseAbs().maxCoeff(),
            0.05 * expected.cwiseAbs().maxCoeff());
  std::vector<int> all(green.anchors().size());
  std::iota(all.begin(), all.end(), 0);
  ASSERT_TRUE(green.GatherAtAnchors(all, from, &got));
  expected = Expected(green, green.anchors(), from);
  EXPECT_LT((got.cast<double>() - expected).cwiseAbs().maxCoeff(),
            kTwoBytes * expected.cwiseAbs().maxCoeff());
}

TEST(NearGreen, TheMemoryLimitIsKept) {
  const Slab slab(8, 0.4);
  NearGreen green(slab.mesh, slab.held, slab.nu, 100'000, {});
  const std::vector<int> all = NodesWithin(green, {0.5, 0.5, 0.5}, 2);
  EXPECT_FALSE(green.Prepare(all, 2));
  EXPECT_LT(green.columns_solved(), 3 * static_cast<int>(all.size()));
}

}  // namespace
}  // namespace palpate
