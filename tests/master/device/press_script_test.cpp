#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "master/device/sim_hand.h"

namespace palpate {
namespace {

constexpr double kScriptTick = 0.001;  // [s]
const Eigen::Vector3d kScriptInward(0, -1, 0);

// A device that is always at its target, at a distance `gap` from the surface.
struct Walk {
  double peak_speed = 0, deepest = -1, contact = 0, held = 0, presses = 0;
};

Walk WalkFor(PressScript& script, double seconds, double gap) {
  Walk walk;
  double depth = -gap;
  for (int i = 0; i * kScriptTick < seconds; ++i) {
    const DeviceGuide guide{true, kScriptInward, -depth};
    const HandIntent intent = script.Step(i * kScriptTick, kScriptTick, guide);
    const double next = intent.p_M.dot(kScriptInward) - gap;
    if (depth <= 0 && next > 0) ++walk.presses;
    depth = next;
    walk.deepest = std::max(walk.deepest, depth);
    walk.peak_speed = std::max(walk.peak_speed, intent.v_M.norm());
    if (depth > 0) walk.contact += kScriptTick;
    if (depth > 0 && intent.v_M.norm() == 0) walk.held += kScriptTick;
  }
  return walk;
}

class PressScriptGapTest : public testing::TestWithParam<double> {};

// Reference: the requested depth. The peak of a minimum-jerk ramp is exact. A tick is at most half
// a millisecond from it, which changes the depth by less than 1e-5 of it on the shortest ramp here.
TEST_P(PressScriptGapTest, PressesToTheDepthAtTheSpeedAndHoldsAThirdOfTheContact) {
  PressScript script(0.005, 0.020, 0.01);
  const Walk walk = WalkFor(script, 8, GetParam());
  EXPECT_NEAR(walk.deepest, 0.005, 1e-9);
  EXPECT_NEAR(walk.peak_speed, 0.020, 1e-6);
  EXPECT_GE(walk.held, walk.contact / 3);
  EXPECT_EQ(walk.presses, 2);
}

INSTANTIATE_TEST_SUITE_P(Gaps, PressScriptGapTest, testing::Values(0.0, 0.001, 0.005, 0.010));

TEST(PressScriptTest, NeverFollowsANonsensicalGuide) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const DeviceGuide& guide :
       {DeviceGuide{true, kScriptInward, nan}, DeviceGuide{true, {0, nan, 0}, 0.001},
        DeviceGuide{true, {0, 0, 0}, 0.001}, DeviceGuide{true, kScriptInward, 1e300}}) {
    PressScript script(0.005, 0.020, 0.01);
    for (int i = 0; i < 6000; ++i) {
      ASSERT_EQ(script.Step(i * kScriptTick, kScriptTick, guide).p_M.norm(), 0) << guide.gap_M;
    }
  }
}

TEST(PressScriptTest, WaitsDuringAShortLossOfTheGuideAndThenContinues) {
  PressScript script(0.005, 0.020, 0.01);
  double advance = 0, before = 0, deepest = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool known = i < 600 || i >= 800;
    advance = script.Step(i * kScriptTick, kScriptTick, {known, kScriptInward, 0.002 - advance})
                  .p_M.dot(kScriptInward);
    if (i == 600) before = advance;
    if (!known) {
      ASSERT_NEAR(advance, before, 1e-12) << i;  // rounding of the clock
    }
    deepest = std::max(deepest, advance);
  }
  EXPECT_GT(before, 0.001);
  EXPECT_NEAR(deepest, 0.007, 1e-9);
}

TEST(PressScriptTest, RetreatsSmoothlyWhenTheGuideStaysLost) {
  PressScript script(0.005, 0.020, 0.01);
  double last = 0;
  bool went_in = false;
  for (int i = 0; i < 4000; ++i) {
    const bool known = i < 700;
    const double advance =
        script.Step(i * kScriptTick, kScriptTick, DeviceGuide{known, kScriptInward, 0.002 - last})
            .p_M.dot(kScriptInward);
    went_in |= advance > 0.001;
    if (!known) {
      EXPECT_LE(advance, last + 1e-12);
    }
    EXPECT_LE(std::abs(advance - last), 0.0201 * kScriptTick) << i;
    last = advance;
  }
  EXPECT_TRUE(went_in);
  EXPECT_EQ(last, 0);
}

}  // namespace
}  // namespace palpate
