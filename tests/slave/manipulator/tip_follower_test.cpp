#include "slave/manipulator/tip_follower.h"

#include <gtest/gtest.h>

#include "tests/support/not_finite.h"

namespace palpate {
namespace {

constexpr double kDt = 1e-3;

ManipulatorOptions Options() {
  return {.home = {0, 0.02, 0},
          .max_speed = 0.05,
          .workspace_min = {-0.1, -0.1, 0},
          .workspace_max = {0.1, 0.1, 0}};
}

void StepFor(TipFollower& follower, double seconds, double dt = kDt) {
  for (double t = 0; t < seconds; t += dt) follower.Step(dt);
}

// Reference: the ramp response of a critically damped second-order servo: it lags by 2 / w. A
// target that moves once per step is held for the step, as the servo sees it.
TEST(TipFollower, LagsAConstantSpeedByTheStatedLag) {
  TipFollower follower(Options());
  const double speed = 0.02;
  for (int k = 1; k <= 200; ++k) {
    follower.Aim({speed * k * kDt, 0.02, 0});
    follower.Step(kDt);
  }
  const double behind = (speed * 200 * kDt - follower.tip().x()) / speed;
  EXPECT_NEAR(behind, TipFollower::kLag, 0.6 * kDt);
  EXPECT_GT(behind, 0);
}

TEST(TipFollower, NeverMovesFasterThanTheLimitNorOvershoots) {
  TipFollower follower(Options());
  follower.Aim({0.1, 0.02, 0});
  bool limited = false;
  Eigen::Vector3d before = follower.tip();
  for (int k = 0; k < 4000; ++k) {
    follower.Step(kDt);
    limited = limited || follower.at_limit();
    EXPECT_LE((follower.tip() - before).norm(), 0.05 * kDt * (1 + 1e-9));
    EXPECT_LE(follower.tip().x(), 0.1);
    before = follower.tip();
  }
  EXPECT_TRUE(limited);
  EXPECT_NEAR(follower.tip().x(), 0.1, 1e-9);
}

// Reference: the closed solution does not depend on the time steps once the target is constant.
TEST(TipFollower, AnyStepIsStableAndEndsInTheSamePlace) {
  for (const double dt : {1e-6, 1e-3, 0.1, 10.0, 1e9}) {
    TipFollower follower(Options());
    follower.Aim({0.001, 0.02, 0});
    for (int k = 0; k < 60 && k * dt < 1e10; ++k) follower.Step(dt);
    EXPECT_TRUE(follower.tip().allFinite()) << dt;
    if (dt >= 0.1) {
      EXPECT_NEAR(follower.tip().x(), 0.001, 1e-9) << dt;
    }
  }
}

TEST(TipFollower, OutsideTheWorkspaceItGoesToTheNearestPlaceInside) {
  TipFollower follower(Options());
  EXPECT_TRUE(follower.Aim({5, -7, 3}));
  EXPECT_TRUE(follower.at_limit());
  StepFor(follower, 10);
  EXPECT_LT((follower.tip() - Eigen::Vector3d(0.1, -0.1, 0)).norm(), 1e-9);
  EXPECT_TRUE(follower.at_limit()) << "the target is still clipped";
  EXPECT_TRUE(follower.Aim({1e300, -1e300, 0}));
  StepFor(follower, 10);
  EXPECT_TRUE(follower.tip().allFinite());
}

TEST(TipFollower, NotFiniteIsIgnored) {
  TipFollower follower(Options());
  follower.Aim({0.01, 0.01, 0});
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_FALSE(follower.Aim({bad, 0, 0}));
    EXPECT_FALSE(follower.Aim({0, 0, bad}));
  }
  for (const double bad : {kNan, kInf, -1.0, 0.0}) follower.Step(bad);
  EXPECT_EQ(follower.tip(), Eigen::Vector3d(0, 0.02, 0)) << "no time has passed";
  StepFor(follower, 1);
  EXPECT_LT((follower.tip() - Eigen::Vector3d(0.01, 0.01, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace palpate
