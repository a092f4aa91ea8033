// Tests that a study states the error of the running estimator: compares the estimates of a
// simulated session without noise, at the deepest image, with the simulator's force.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/own_model.h"
#include "slave/study/volume_force.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/simulator/environment_player.h"
#include "tests/support/paths.h"

namespace palpate::study {
namespace {

constexpr double kFactor = 1.3;    // allowed factor between stated and true error
constexpr double kOfTruth = 6e-4;  // relative accuracy of the simulators' forces

Scene Shipped(const std::string& name, const std::vector<std::string>& overrides) {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/" + name + ".yaml"), overrides);
  scene.site.noise = scene.site.flicker = scene.site.lighting = 0;
  return scene;
}

// With one camera the error is that of the model's answer at the true depth, without errors of the
// image.
double RunningError(const Scene& scene) {
  const auto environment = MakeSimulatedEnvironment(scene);
  EnvironmentPlayer player(*environment, scene);
  const auto sense = MakeSensingPipeline(scene, {.player = &player});
  const auto report = sense->OpenOfflineReport(environment.get());
  double deepest = 0, error = kUnknown;
  while (sense->Acquire({})) {
    const Truth truth = environment->truth();
    sense->Process();
    const ContactEstimate estimate = sense->Estimate({truth.p_S_tip, 0});
    report->Add(estimate.sensed_at, &truth);
    if (!estimate.force || truth.force.norm() <= deepest) continue;
    deepest = truth.force.norm();
    const double estimated = scene.sense.Find<Camera>() ? report->compared().back().model_at_truth
                                                        : estimate.force->norm();
    error = std::abs(estimated / deepest - 1);
  }
  return error;
}

void ExpectStatedAsItRuns(const Scene& scene, double running) {
  const StudyRow row = StudyOwn(scene, DefaultModelFactory()).row;
  ASSERT_EQ(row.outcome, Outcome::kAnswered) << row.reason;
  std::printf("stated %.3f %%, deviation %.3f %%, running %.3f %%\n", 100 * row.error.value,
              100 * row.deviation, 100 * running);
  EXPECT_LT(row.error.value, kFactor * running + kOfTruth);
  EXPECT_GT(row.error.value, running / kFactor - kOfTruth);
}

TEST(RunningStudyTest, BlockBeforeOneCamera) {
  for (const int elements : {20, 60, 180}) {
    SCOPED_TRACE(elements);
    const Scene scene = Shipped("silicone-block", {"model.elements=" + std::to_string(elements)});
    ExpectStatedAsItRuns(scene, RunningError(scene));
  }
}

TEST(RunningStudyTest, RoundToolBeforeOneCamera) {
  for (const int elements : {120, 360}) {
    SCOPED_TRACE(elements);
    const Scene scene =
        Shipped("silicone-block", {"model.elements=" + std::to_string(elements),
                                   "tool={shape: round, radius: 8 mm, depth: whole}"});
    ExpectStatedAsItRuns(scene, RunningError(scene));
  }
}

TEST(RunningStudyTest, MembraneBeforeAStereoPair) {
  for (const int modes : {6, 10, 16}) {
    SCOPED_TRACE(modes);
    Scene scene = Shipped("rubber-membrane", {});
    scene.model.modes = modes;
    ExpectStatedAsItRuns(scene, RunningError(scene));
  }
}

// Fingertips measure their force, so the study examines the scene's model under the tool, as
// `solve` does. The true force is that of a finer mesh than the study's, accurate to 1 %: meshes
// that divide the disc differently differ by as much.
TEST(RunningStudyTest, CubeUnderATool) {
  for (const int cells : {4, 6, 9}) {
    SCOPED_TRACE(cells);
    const std::string n = std::to_string(cells);
    Scene scene =
        Shipped("foam-cube", {"object.geometry.box.cells=[" + n + ", " + n + ", " + n + "]"});
    scene.operator_options.press_depth = 1e-4;  // linear, as the model is
    const PressSpec question = AskedOf(scene);
    const Press& press = question.presses.front();
    const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
    const ContactResponse response = contacts::Answer(
        *model, contacts::Move(press.p_O, question.depth * press.inward_O, question.width));
    const auto truth = VolumeForce(scene, press, question.width, question.depth, kFineGrading);
    ASSERT_TRUE(truth);
    ExpectStatedAsItRuns(scene, std::abs(press.inward_O.dot(response.force_O) / truth->value - 1));
  }
}

}  // namespace
}  // namespace palpate::study
