// Paper B, IV.C and figure 13: three shapes in three foams, each seen unoccluded, occluded by the
// fingers that touch it, and deformed by them. The paper's sponge fell behind; here none may.
#include <cstdio>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "slave/study/shape/simulated_experiment.h"
#include "slave/study/shape/simulated_report.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

class NineObjects : public testing::TestWithParam<std::string> {};

// The truth is a neo-Hookean body on a finer mesh of its own; the estimate has tactile samples and
// the fingertips' poses. Tolerances: two points of the octree score are what is asked for. Of the
// surface, 95 % lie within a third of the press and the mean within a tenth of it: more is not told
// by elements of 10 mm under fingertips of 7 mm.
TEST_P(NineObjects, DeformedShapeScoresWithinTwoPointsOfTheUnoccludedOne) {
  const fs::path file = fs::path(SourcePath()) / "deploy/scenes" / (GetParam() + ".yaml");
  const Scene scene = LoadScene(file);
  std::vector<study::SimulatedObject> objects;
  study::ExperimentOptions options;
  options.repetitions = 2;
  for (const study::Foam& foam : study::kFoams) {
    objects.push_back(study::RunExperiment(MadeOf(foam, scene), options));
    objects.back().material = foam.name;
    const auto& [unoccluded, occluded, deformed] = objects.back().states;
    EXPECT_GE(deformed.mean_octree(), unoccluded.mean_octree() - 0.02) << foam.name;
    EXPECT_GE(occluded.mean_octree(), unoccluded.mean_octree() - 0.02) << foam.name;
    const double press = scene.operator_options.press_depth;
    EXPECT_GT(deformed.displacement, 0.9 * press) << foam.name;
    EXPECT_LT(deformed.error.p95, press / 3) << foam.name;
    EXPECT_LT(deformed.error.mean, press / 10) << foam.name;
  }
  std::fputs(study::ToTable(objects).c_str(), stdout);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NineObjects,
                         testing::Values("foam-cube", "foam-sponge", "foam-bar"),
                         [](const auto& scene) { return scene.param.substr(5); });

}  // namespace
}  // namespace palpate
