// A person presses the shipped block before a camera. The simulated images have a tool that tilts
// and shakes, automatic exposure, the shadow of the hand and an uncorrected lens. The simulator
// knows the force.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>

#include "slave/pipeline/camera/estimator.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/camera/simulated_site.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

class HandHeldTest : public testing::TestWithParam<std::uint32_t> {};

// Bound: 10 % of the peak (rms) for a hand-held tool, or flagged; 20 % for single forces. Half of
// the images in contact must be valid, since a press that is flagged throughout would test nothing.
TEST_P(HandHeldTest, ValidForcesOfAHandHeldPressAreWithinATenthOfThePeak) {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"));
  scene.site.seed = GetParam();
  scene.site.hand = SiteOptions::Hand{.tilt = 15 * std::numbers::pi / 180,
                                      .tremor = 0.3e-3,
                                      .exposure = 0.2,
                                      .shadow = 0.3,
                                      .jitter = 0.3,
                                      .lens = 0.005};
  SimulatedSite site(scene);
  const auto camera = site.OpenCamera(scene, ScriptedRun{});
  auto frame = camera->Next({});
  ASSERT_TRUE(frame);
  Estimator estimator(scene, *frame, scene.manipulator.home);
  double peak = 0, square = 0, worst = 0;
  int valid = 0, touching = 0, compared = 0;
  for (; frame; frame = camera->Next({})) {
    const double truth = site.truth().force.norm();
    const ContactEstimate& estimate = estimator.Estimate(*frame);
    peak = std::max(peak, truth);
    if (truth > 0) ++touching;
    if (estimate.validity != Validity::kValid) continue;
    if (truth > 0) ++valid;
    const double error = std::abs(estimate.force->norm() - truth);
    square += error * error;
    worst = std::max(worst, error);
    ++compared;
  }
  ASSERT_GT(compared, 0);
  EXPECT_LT(std::sqrt(square / compared), 0.1 * peak);
  EXPECT_LT(worst, 0.2 * peak);
  EXPECT_GE(2 * valid, touching) << valid << " of " << touching;
}
INSTANTIATE_TEST_SUITE_P(Seeds, HandHeldTest, testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace palpate
