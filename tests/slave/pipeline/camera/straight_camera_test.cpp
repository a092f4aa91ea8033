// Tests a camera whose lens distorts straight lines, from the images to the tip.
#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "shared/wire/enum_names.h"
#include "slave/pipeline/camera/estimator.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/camera/simulated_site.h"
#include "slave/vision/stereo/rig.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

// The shipped block, seen by a camera with barrel distortion.
Scene BlockBehindALens() {
  const auto folder = std::filesystem::path(BinaryPath()) / "test-output";
  std::filesystem::create_directories(folder);
  StereoRig camera;
  camera.left = {500, 500, 322, 236, {-0.3, 0.1, 0.001, -0.0005, 0}, {640, 480}};
  WriteRig(folder / "straight-lens.yaml", camera);
  Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"));
  scene.sense.Find<Camera>()->lens = folder / "straight-lens.yaml";
  return scene;
}

// Reference: the true position of the simulated tool. Tolerance: a tenth of a pixel; without
// correction of the lens the error is up to two pixels.
TEST(StraightCameraTest, TheTipIsFoundToATenthOfAPixelThroughALens) {
  const Scene scene = BlockBehindALens();
  SimulatedSite site(scene);
  const auto camera = site.OpenCamera(scene, ScriptedRun{});
  std::optional<Frame> frame = camera->Next({});
  ASSERT_TRUE(frame);
  Estimator estimator(scene, *frame, scene.manipulator.home);
  const double pixel = scene.sense.Find<Camera>()->pixel;
  double worst = 0, unstraightened = 0;
  int compared = 0;
  const Lens lens = ReadRig(scene.sense.Find<Camera>()->lens).left;
  for (int i = 0; frame && i < 60; ++i, frame = camera->Next({})) {
    const ContactEstimate& estimate = estimator.Estimate(*frame);
    ASSERT_TRUE(estimator.observation().tip.found) << i;
    worst = std::max(worst, (estimate.p_S_tip - site.truth().p_S_tip).norm() / pixel);
    const Eigen::Vector2d seen = estimator.view().ToImage(site.truth().p_S_tip);
    const Eigen::Vector3d ray((seen.x() - lens.cx) / lens.fx, (seen.y() - lens.cy) / lens.fy, 1);
    unstraightened = std::max(unstraightened, (*Project(lens, ray) - seen).norm());
    ++compared;
  }
  EXPECT_EQ(compared, 60);
  EXPECT_LT(worst, 0.1);
  EXPECT_GT(unstraightened, 1) << "or the lens shows nothing";
}

// The shipped embryo, whose outline and pipette direction come from the images only. Reference: the
// simulated force. Tolerance 15 %: the outline found is smoothed by the snake's 60 points, and the
// supporting arc is stated relative to its centre.
TEST(FromImageTest, TheEmbryoOfTheImageIsEstimatedByAPipetteThatPointsAtIt) {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/zebrafish-embryo.yaml"));
  scene.site.embryo.reset();  // linear, and it does not break
  scene.operator_options.press_depth = 100e-6;
  SimulatedSite site(scene);
  const auto camera = site.OpenCamera(scene, ScriptedRun{});
  scene.object.geometry = ImageContourGeometry{1.2e-3};
  scene.tool->direction.setZero();
  std::optional<Frame> frame = camera->Next({});
  ASSERT_TRUE(frame);
  Estimator estimator(scene, *frame, scene.manipulator.home);
  EXPECT_LT((estimator.tracker().tool_direction_I() - Eigen::Vector2d(-1, 0)).norm(), 0.1);
  double peak = 0, worst = 0;
  int valid = 0, images = 0;
  std::string checks;
  for (; frame; frame = camera->Next({})) {
    const ContactEstimate& estimate = estimator.Estimate(*frame);
    const Eigen::Vector3d truth = site.truth().force;
    peak = std::max(peak, truth.norm());
    ++images;
    if (estimate.validity != Validity::kValid)
      checks += std::string(ToString(estimate.check)) + " ";
    if (estimate.validity != Validity::kValid) continue;
    ++valid;
    worst = std::max(worst, (estimate.force.value() - truth).norm());
  }
  EXPECT_GT(peak, 0.01);
  EXPECT_LT(worst, 0.15 * peak);
  EXPECT_GT(valid, images / 2) << checks;
}

}  // namespace
}  // namespace palpate
