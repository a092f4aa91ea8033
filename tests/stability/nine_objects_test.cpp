// Paper B, IV.C and figure 13: three shapes in three foams, each seen unoccluded, occluded by the
// fingers that touch it, and deformed by them. The paper's sponge fell behind; here none may.
#include <filesystem>
#include <string>
#include <string_view>
#include <tuple>

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "slave/scene/scene_loader.h"
#include "tests/stability/simulated_experiment.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// The paper's foams (table III; Poisson's ratio from the authors' material files).
struct Foam {
  std::string_view name;
  double young_modulus, density;  // [Pa], [kg/m^3]
};
constexpr Foam kFoams[] = {{"hard", 3800, 45}, {"medium", 3200, 30}, {"soft", 3000, 26}};

class NineObjects : public testing::TestWithParam<std::tuple<std::string, Foam>> {};

// The truth is a neo-Hookean body on a finer mesh of its own; the estimate has tactile samples and
// the fingertips' poses. Tolerances: two points of the octree score are what is asked for. Of the
// surface, 95 % lie within a third of the press and the mean within a tenth of it: more is not
// stated by elements of 10 mm under fingertips of 7 mm.
TEST_P(NineObjects, DeformedShapeScoresWithinTwoPointsOfTheUnoccludedOne) {
  const auto& [name, foam] = GetParam();
  const fs::path file = fs::path(SourcePath()) / "deploy/scenes" / ("foam-" + name + ".yaml");
  const Scene scene =
      LoadScene(file, {fmt::format("object.material.young_modulus={} Pa", foam.young_modulus),
                       fmt::format("object.material.density={} kg/m3", foam.density),
                       "object.material.poisson_ratio=0.15"});
  study::ExperimentOptions options;
  options.repetitions = 2;
  const study::SimulatedObject object = study::RunExperiment(scene, options);
  const auto& [unoccluded, occluded, deformed] = object.states;
  EXPECT_GE(deformed.mean_octree(), unoccluded.mean_octree() - 0.02);
  EXPECT_GE(occluded.mean_octree(), unoccluded.mean_octree() - 0.02);
  const double press = scene.operator_options.press_depth;
  EXPECT_GT(deformed.displacement, 0.9 * press);
  EXPECT_LT(deformed.error.p95, press / 3);
  EXPECT_LT(deformed.error.mean, press / 10);
  fmt::print("{}, {}: octree score {:.2f} % unoccluded, {:.2f} % deformed\n", object.name,
             foam.name, 100 * unoccluded.mean_octree(), 100 * deformed.mean_octree());
}

std::string InWords(const testing::TestParamInfo<NineObjects::ParamType>& object) {
  return std::get<0>(object.param) + "_" + std::string(std::get<1>(object.param).name);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NineObjects,
                         testing::Combine(testing::Values("cube", "sponge", "bar"),
                                          testing::ValuesIn(kFoams)),
                         InWords);

}  // namespace
}  // namespace palpate
