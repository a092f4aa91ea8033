#include "slave/site/camera/scripted_press.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/site/camera/simulated_site.h"
#include "tests/slave/site/camera/site_scenes.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using site::BlockScene;
using site::EmbryoScene;

Scene Shifted(Scene scene, const Eigen::Vector2d& misplacement) {
  scene.site.misplacement = misplacement;
  return scene;
}

class ScriptedPressTest : public ::testing::TestWithParam<Scene> {
 protected:
  Scene scene_ = GetParam();
  ScriptedPress press_{scene_, 2};
};

TEST_P(ScriptedPressTest, PeaksAtTheWantedTrueDepth) {
  SimulatedSite site(scene_);
  const int steps = 400;
  for (int k = 0; k <= steps; ++k) site.MoveTool(press_.Tip(press_.hold_begin() * k / steps));
  EXPECT_NEAR(site.truth().depth / scene_.operator_options.press_depth, 1, 1e-3);
}

TEST_P(ScriptedPressTest, HoldLastsAtLeastAThirdOfTheContact) {
  const double hold = press_.hold_end() - press_.hold_begin();
  EXPECT_GE(hold, (press_.contact_end() - press_.contact_begin()) / 3 * (1 - 1e-12));
  EXPECT_GE(hold, ScriptedPress::kHold * (1 - 1e-12));
  EXPECT_EQ(press_.Tip(press_.hold_begin() + 1e-3 * hold),
            press_.Tip(press_.hold_end() - 1e-3 * hold));
}

TEST_P(ScriptedPressTest, TheSurfaceIsMetAtTheStatedTime) {
  const Eigen::Vector3d at = press_.Tip(press_.contact_begin());
  EXPECT_NEAR((at - scene_.manipulator.home).norm() / press_.gap(), 1, 1e-9);
  EXPECT_LT((press_.Tip(press_.contact_end()) - at).norm() / press_.gap(), 1e-9);
}

// Reference: the peak speed of a minimum-jerk motion is 15/8 of its mean.
TEST_P(ScriptedPressTest, ReachesTheSpeedAndNeverExceedsIt) {
  const double dt = press_.duration() / 200000;
  double fastest = 0;
  for (int k = 0; k < 200000; ++k) {
    fastest = std::max(fastest, (press_.Tip((k + 1) * dt) - press_.Tip(k * dt)).norm() / dt);
  }
  const double speed = std::min(scene_.operator_options.press_speed, scene_.manipulator.max_speed);
  EXPECT_NEAR(fastest / speed, 1, 1e-4);
}

TEST_P(ScriptedPressTest, StartsAndEndsAtHomeAndRepeats) {
  const double period = press_.duration() / 2;
  for (const double t : {-1.0, 0.0, period, 2 * period, 1e9, std::nan("")}) {
    EXPECT_LT((press_.Tip(t) - scene_.manipulator.home).norm(), 1e-12) << t;
  }
  EXPECT_LT((press_.Tip(0.3 * period) - press_.Tip(1.3 * period)).norm(),
            1e-9 * scene_.operator_options.press_depth);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ScriptedPressTest,
                         ::testing::Values(BlockScene(), Shifted(BlockScene(), {3e-4, -2e-4}),
                                           EmbryoScene(), Shifted(EmbryoScene(), {2e-6, 1e-6})));

std::string Refusal(const Scene& scene) {
  return Thrown<std::invalid_argument>([&] { const ScriptedPress press(scene); });
}

TEST(ScriptedPress, RefusalsNameTheKey) {
  Scene scene = BlockScene();
  scene.tool.reset();
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("tool"));
  scene = BlockScene();
  scene.tool->direction = {0, 1};
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("tool.direction"));
  scene = BlockScene();
  scene.manipulator.home = {0.04, 0.04, 0};
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("manipulator.home"));
  scene = BlockScene();
  scene.operator_options.press_depth = std::nan("");
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("operator.press.depth"));
  scene = BlockScene();
  scene.operator_options.press_speed = 0;
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("operator.press.speed"));
}

}  // namespace
}  // namespace palpate
