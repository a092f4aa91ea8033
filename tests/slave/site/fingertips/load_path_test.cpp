#include "slave/site/fingertips/load_path.h"

#include <cmath>

#include <gtest/gtest.h>

namespace palpate::site {
namespace {

using Eigen::Vector3d;

// A ladder of one finger whose force is (c s^1.5 up, linear across), depth s, from s = 1 on.
Rungs PowerLadder() {
  Rungs rungs;
  for (const double way : {0.0, 0.1, 0.25, 0.5, 1.0, 1.7, 2.4}) {
    auto rung = std::make_shared<LoadStep>();
    rung->s = 1 + way;
    FingerTouch& touch = rung->touches[0];
    touch.touching = way > 0;
    touch.force_O = Vector3d(0, way, -std::pow(way, 1.5));
    touch.p_F = Vector3d(0, 0, -7e-3 + 1e-3 * way);
    touch.depth = way;
    touch.radius = way;
    rung->displacements_O = {Eigen::Vector3f(0, 0, -static_cast<float>(way)),
                             Eigen::Vector3f(0, 0, 0)};
    rungs.push_back(std::move(rung));
  }
  return rungs;
}

TEST(LoadPath, AnswersAtTheRungsAreThoseOfTheRungs) {
  const Rungs rungs = PowerLadder();
  for (std::size_t i = 1; i < rungs.size(); ++i) {
    const TouchBetween at = TouchAt(rungs, 0, rungs[i]->s);
    EXPECT_TRUE(at.touch.touching);
    EXPECT_LT((at.touch.force_O - rungs[i]->touches[0].force_O).norm(), 1e-12);
    EXPECT_NEAR(at.touch.depth, rungs[i]->touches[0].depth, 1e-12);
  }
}

// Reference: the power law of Hertz's contact. The worst between these rungs is 2.47 % of
// the force there, right after the first touch excepted.
TEST(LoadPath, ForcesBetweenTheRungsFollowTheLaw) {
  const Rungs rungs = PowerLadder();
  double last = 0;
  for (double way = 0.1; way < 2.4; way += 0.01) {
    const TouchBetween at = TouchAt(rungs, 0, 1 + way);
    const double law = std::pow(way, 1.5);
    EXPECT_NEAR(-at.touch.force_O.z(), law, 0.025 * law) << way;
    EXPECT_NEAR(at.touch.force_O.y(), way, 0.02 * way + 0.005);
    EXPECT_GT(-at.touch.force_O.z(), last);
    EXPECT_GT(at.slope, 0);
    last = -at.touch.force_O.z();
  }
}

TEST(LoadPath, NothingTouchesBeforeAndEverythingGoesOnBeyond) {
  const Rungs rungs = PowerLadder();
  EXPECT_FALSE(TouchAt(rungs, 0, 1.0).touch.touching);
  EXPECT_FALSE(TouchAt(rungs, 0, -5.0).touch.touching);
  EXPECT_FALSE(TouchAt(rungs, 1, 2.0).touch.touching);  // another finger
  EXPECT_FALSE(TouchAt({}, 0, 2.0).touch.touching);
  const double end = std::pow(2.4, 1.5), before = std::pow(1.7, 1.5);
  const TouchBetween beyond = TouchAt(rungs, 0, 1 + 2.4 + 0.35);
  EXPECT_NEAR(-beyond.touch.force_O.z(), end + 0.5 * (end - before), 1e-12);
  EXPECT_NEAR(beyond.touch.depth, 2.75, 1e-12);
  std::vector<Vector3d> u;
  DisplacementsAt(rungs, 9.0, &u);
  EXPECT_NEAR(u[0].z(), -2.4, 1e-6);
  DisplacementsAt(rungs, 0.5, &u);
  EXPECT_EQ(u[0].norm(), 0);
  DisplacementsAt(rungs, 1.75, &u);
  EXPECT_NEAR(u[0].z(), -0.75, 1e-6);
}

}  // namespace
}  // namespace palpate::site
