// The report of a simulated experiment, from made-up scores.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slave/scene/scene_loader.h"
#include "slave/study/shape/simulated_experiment.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate::study {
namespace {

using testing::HasSubstr;

SimulatedObject MadeUp(const std::string& name, const std::vector<double>& deformed) {
  SimulatedObject object;
  object.name = name;
  object.true_force = 0.5;
  object.estimated_force = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t s = 0; s < 3; ++s) {
    ShapeState& state = object.states[s];
    state.name = std::array{"unoccluded", "occluded", "deformed"}[s];
    for (const double octree : s == 2 ? deformed : std::vector<double>{0.98, 0.99}) {
      state.scores.push_back({octree, 10, 10, {}, {}});
      state.undeformed.push_back(octree);
    }
  }
  return object;
}

TEST(SimulatedReportTest, TableSaysByHowMuchTheDeformedStateFallsBehind) {
  const std::string table = ToTable({MadeUp("a <b>", {0.95, 0.97})});
  EXPECT_THAT(table,
              HasSubstr("deformed against unoccluded -2.50 points, force unknown of 0.500 N"));
  EXPECT_THAT(table, HasSubstr("95.0 % to 97.0 %"));
}

TEST(SimulatedReportTest, TheReportHasTheScoresOfEveryState) {
  const std::vector<SimulatedObject> objects{MadeUp("a", {0.2, 0.4}), MadeUp("d", {0, 1})};
  const Scratch folder;
  ASSERT_TRUE(WriteSimulated(objects, 0.01, folder.path()));
  const auto report = nlohmann::json::parse(Scratch::Read(folder / "report.json"));
  EXPECT_EQ(report["objects"][1]["states"][2]["octree_mean"], 0.5);
  EXPECT_TRUE(report["objects"][0]["estimated_force_N"].is_null());
  EXPECT_FALSE(WriteSimulated(objects, 0.01, folder / "no such folder"));
}

TEST(FoamTest, SceneIsMadeOfTheFoamAndNothingElseChanges) {
  const Scene scene =
      LoadScene(SourcePath("/deploy/scenes/foam-cube.yaml"), {"object.material.tolerance=0.1"});
  const Scene soft = MadeOf(kFoams[2], scene);
  EXPECT_EQ(soft.object.material.young_modulus, 3000);
  EXPECT_EQ(soft.object.material.density, 26);
  EXPECT_EQ(soft.object.material.poisson_ratio, 0.15);
  EXPECT_EQ(soft.object.material.young_modulus_tolerance, 0.1);
  EXPECT_EQ(soft.name, scene.name);
}

}  // namespace
}  // namespace palpate::study
