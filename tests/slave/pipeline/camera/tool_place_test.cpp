// Tool ends that differ from the scene, and tilted round ends, in simulated images of a press. The
// simulator gives the true force.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/pipeline/camera/estimator.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/camera/simulated_site.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

struct PressOutcome {
  int touching = 0, valid = 0;
  // Largest error of valid forces in contact, relative to the largest true force [-].
  double worst = 0;
};

// Runs the scene's scripted press and estimates from each image.
PressOutcome RunPress(const Scene& scene, std::optional<Eigen::Vector3d> p_S_tip) {
  constexpr double kTouches = 0.01;  // of the largest true force
  SimulatedSite site(scene);
  const auto camera = site.OpenCamera(scene, ScriptedRun{});
  auto frame = camera->Next({});
  Estimator estimator(scene, *frame, p_S_tip);
  struct Image {
    double truth, error;
    bool is_valid;
  };
  std::vector<Image> images;
  double peak = 0;
  for (; frame; frame = camera->Next({})) {
    const ContactEstimate& estimate = estimator.Estimate(*frame);
    const Eigen::Vector3d truth = site.truth().force;
    peak = std::max(peak, truth.norm());
    images.push_back({truth.norm(), estimate.force ? (*estimate.force - truth).norm() : 0,
                      estimate.validity == Validity::kValid});
  }
  PressOutcome outcome;
  for (const Image& image : images) {
    if (image.truth < kTouches * peak) continue;
    ++outcome.touching;
    if (!image.is_valid) continue;
    ++outcome.valid;
    outcome.worst = std::max(outcome.worst, image.error / peak);
  }
  return outcome;
}

Scene BlockAt(double rate) {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"));
  scene.sense.Find<Camera>()->rate = rate;
  return scene;
}

// Bound: the promised accuracy of a `valid` force with a template cut by hand. A correct anchor
// causes no loss.
TEST(TemplateAnchorTest, NoValidForceIsOffByMoreThanATenthOfThePeak) {
  const Scratch folder;
  Scene scene = BlockAt(20);
  SimulatedSite site(scene);
  const cv::Mat first = site.TakeImage();
  const Camera& camera = *scene.sense.Find<Camera>();
  const Eigen::Vector2d tip =
      CameraView(camera, first.cols, first.rows).ToImage(scene.manipulator.home);
  const cv::Rect box(static_cast<int>(tip.x()) - 14, static_cast<int>(tip.y()) - 45, 30, 44);
  auto* tracking = scene.sense.Find<TipTracking>();
  tracking->template_file = folder.path() / "tip.png";
  WriteWholeFile(tracking->template_file, EncodePng(first(box).clone()));
  for (const double off : {-3.0, -2.0, 0.0, 2.0, 5.0}) {  // [px]
    tracking->anchor = tip - Eigen::Vector2d(box.x, box.y - off);
    const PressOutcome outcome = RunPress(scene, std::nullopt);
    EXPECT_LE(outcome.worst, 0.1) << off << " px";
    if (off == 0) EXPECT_EQ(outcome.valid, outcome.touching);
  }
}

constexpr double kDegree = std::numbers::pi / 180;

Scene UnderARoundEnd(double radius) {
  Scene scene = BlockAt(20);
  scene.sense.Find<Camera>()->pixel = 0.25e-3;
  scene.tool->shape = Tool::Shape::kRound;
  scene.tool->radius = radius;
  scene.tool->width = 2 * radius;
  return scene;
}

// Bounds: a tenth of the peak, and four of five states valid.
void ExpectRightAndValid(const Scene& scene, double degrees) {
  const PressOutcome outcome = RunPress(scene, scene.manipulator.home);
  EXPECT_LE(outcome.worst, 0.1) << degrees;
  EXPECT_GE(outcome.valid, 0.8 * outcome.touching) << degrees;
}

// The shaft has a constant tilt.
TEST(LeaningToolTest, ARoundEndThatLeansIsItsCentre) {
  Scene scene = UnderARoundEnd(5e-3);
  for (const double degrees : {0.0, -15.0, 20.0}) {
    const double lean = degrees * kDegree;
    scene.tool->direction = {std::sin(lean), -std::cos(lean)};
    ExpectRightAndValid(scene, degrees);
  }
}

// The shaft rotates in the operator's hand, also during the approach: the end rolls on the block.
TEST(LeaningToolTest, ARoundEndThatTurnsRolls) {
  for (const double radius : {5e-3, 10e-3}) {
    Scene scene = UnderARoundEnd(radius);
    scene.site.hand = SiteOptions::Hand{.tilt = 20 * kDegree};
    ExpectRightAndValid(scene, 20);
  }
}

// A rotated flat face touches with a corner before its centre; this must not be reported as a wrong
// anchor.
TEST(LeaningToolTest, AFlatFaceThatTurnsIsValid) {
  Scene scene = BlockAt(20);
  scene.sense.Find<Camera>()->pixel = 0.25e-3;
  scene.site.hand = SiteOptions::Hand{.tilt = 20 * kDegree};
  scene.site.seed = 77;  // it rotates a lot before contact
  ExpectRightAndValid(scene, 20);
}

}  // namespace
}  // namespace palpate
