#include "slave/study/study.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <stop_token>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/model_kinds.h"
#include "slave/study/candidate.h"
#include "slave/study/reference.h"
#include "tests/slave/study/fake_model_factory.h"

namespace palpate::study {
namespace {

using fake::Scenario;
using testing::HasSubstr;

std::size_t CountOf(const StudyResult& study, Outcome outcome) {
  return static_cast<std::size_t>(
      std::ranges::count(study.rows, outcome, [](const StudyRow& row) { return row.outcome; }));
}

const StudyRow& RowOf(const StudyResult& study, const std::string& family,
                      const std::string& resolution) {
  for (const StudyRow& row : study.rows) {
    if (row.family == family && row.resolution == resolution) return row;
  }
  throw std::out_of_range(family + " " + resolution);
}

TEST(QuestionTest, PlanarObjectsArePressedWhereTheToolComesFrom) {
  Scene scene = fake::Square();
  scene.object.X_SO.setIdentity();
  PressSpec question = AskedOf(scene);
  ASSERT_EQ(question.presses.size(), 1U);
  EXPECT_TRUE(question.presses[0].p_O.isApprox(Eigen::Vector3d(0.03, 0.06, 0)));
  EXPECT_TRUE(question.presses[0].inward_O.isApprox(Eigen::Vector3d(0, -1, 0)));
  scene.manipulator.home = {0.09, 0.02, 0};
  question = AskedOf(scene);
  EXPECT_TRUE(question.presses[0].p_O.isApprox(Eigen::Vector3d(0.06, 0.02, 0)));
  EXPECT_TRUE(question.presses[0].inward_O.isApprox(Eigen::Vector3d(-1, 0, 0)));
  EXPECT_EQ(question.width, 0.004);
  EXPECT_EQ(question.depth, scene.operator_options.press_depth);
}

TEST(QuestionTest, VolumesArePressedOppositeToWhatIsHeld) {
  Scene scene = fake::Square();
  scene.object.geometry = BoxGeometry{{0.06, 0.04, 0.05}, {3, 2, 4}};
  scene.object.fixed = {{FixedPlane{2, 0}, {true, true, true}}};
  Press press = AskedOf(scene).presses.at(0);
  EXPECT_TRUE(press.p_O.isApprox(Eigen::Vector3d(0.03, 0.02, 0.05)));
  EXPECT_TRUE(press.inward_O.isApprox(Eigen::Vector3d(0, 0, -1)));
  EXPECT_FALSE(press.loaded);
  scene.object.fixed = {{FixedPlane{0, 0.06}, {true, true, true}}};
  press = AskedOf(scene).presses.at(0);
  EXPECT_NEAR(press.p_O.x(), 0, 1e-12);
  EXPECT_TRUE(press.inward_O.isApprox(Eigen::Vector3d(1, 0, 0)));
}

TEST(QuestionTest, MembranesArePressedBelowHome) {
  Scene scene = fake::Square();
  scene.object.X_SO.setIdentity();
  scene.object.geometry = MembraneGeometry{0.038, 0.001};
  scene.manipulator.home = {0.01, -0.02, 0.005};
  const PressSpec question = AskedOf(scene);
  ASSERT_EQ(question.presses.size(), 1U);
  EXPECT_TRUE(question.presses[0].p_O.isApprox(Eigen::Vector3d(0.01, -0.02, 0)));
  EXPECT_NEAR(question.small_depth, 1e-5, 1e-15) << "a hundredth of the thickness";
  scene.manipulator.home = {0.1, 0, 0.005};
  EXPECT_EQ(AskedOf(scene).presses.at(0).p_O.norm(), 0);
}

TEST(CandidateTest, PlanarScenesGetEveryOrderAtResolutionsThatFitTheTool) {
  const Scene scene = fake::Square();
  const PressSpec question = AskedOf(scene);
  std::set<std::string> families;
  bool own = false;
  for (const Candidate& c : CandidatesFor(scene, question)) {
    families.insert(c.family);
    own = own || c.scene.model.elements == scene.model.elements;
    EXPECT_GE(c.scene.model.elements, 20);
    EXPECT_LE(c.scene.model.elements, 1500);
    if (c.scene.model.elements < 60) continue;
    // 60 elements are as long as the tool is wide: finer ones divide it.
    // 240 mm of outline by 4 mm of tool.
    EXPECT_EQ(std::stoi(c.resolution) % 60, 0) << c.resolution;
  }
  EXPECT_THAT(families, testing::ElementsAre("bem2d constant", "bem2d linear", "bem2d quadratic"));
  EXPECT_TRUE(own) << "the scene's own resolution";
}

TEST(CandidateTest, VolumesGetSeveralResolutionsResidualsAndFormulations) {
  Scene scene = fake::Square();
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.06}, {6, 6, 6}};
  scene.object.fixed = {{FixedPlane{2, 0}, {true, true, true}}};
  std::set<std::string> families, own_sizes;
  std::set<double> residuals;
  for (const Candidate& c : CandidatesFor(scene, AskedOf(scene))) {
    families.insert(c.family);
    if (c.family == "fem tet4 linear") own_sizes.insert(c.resolution);
    if (c.family == "fem tet4 corotational") residuals.insert(c.scene.model.fem.residual);
  }
  EXPECT_THAT(families,
              testing::ElementsAre("fem tet10 linear", "fem tet10 neo-hookean",
                                   "fem tet4 corotational", "fem tet4 linear",
                                   "fem tet4 neo-hookean", "fem-green", "fem-green tet10"));
  EXPECT_THAT(residuals, testing::ElementsAre(1e-9, 1e-6, 1e-3));
  EXPECT_THAT(own_sizes, testing::Contains("6 x 6 x 6 cells"));
  EXPECT_GE(own_sizes.size(), 4U);
}

// Reference: the springs' own law, stiffness 100 (1 - 3 / N), whose limit is 100.
TEST(StudyTest, ErrorsAreThoseAgainstTheLimitThatTheModelsConvergeTo) {
  Scenario scenario;
  const StudyResult study = RunStudy(fake::Square(), {.timing_s = 1e-4}, scenario.Make());
  EXPECT_TRUE(study.complete);
  EXPECT_EQ(CountOf(study, Outcome::kAnswered), study.rows.size());
  for (const StudyRow& row : study.rows) {
    const double elements = std::stod(row.resolution);
    EXPECT_NEAR(row.deviation, 3 / elements, 1e-6) << row.family << row.resolution;
  }
  const Reference& reference = study.references.presses.at(0);
  EXPECT_NEAR(reference.full.value, 100 * study.question.depth, 1e-6);
  EXPECT_THAT(reference.source, HasSubstr("order 1.00"));
}

// Reference: the fake clock. Every second is one that the models used.
TEST(StudyTest, BudgetIsRespectedAndTheRestListedWithItsCost) {
  Scenario scenario;
  // Three seconds at 300 elements, 81 at 900.
  scenario.precompute = [](const Scene& scene) {
    return 3 * std::pow(scene.model.elements / 300., 3);
  };
  StudySettings settings{.budget_s = 40, .timing_s = 1e-4};
  const double began = scenario.clock;
  const StudyResult study = RunStudy(fake::Square(), settings, scenario.Make());
  EXPECT_FALSE(study.complete);
  // Costs are estimated in advance: once, the first model of an order may be more expensive than
  // estimated.
  EXPECT_LE(scenario.clock - began, settings.budget_s * 1.5);
  EXPECT_GE(CountOf(study, Outcome::kAnswered), 10U);
  double left_out = 0;
  for (const StudyRow& row : study.rows) {
    if (row.outcome != Outcome::kSkipped) continue;
    EXPECT_THAT(row.reason, HasSubstr("budget"));
    EXPECT_GT(row.expected_s, 0);
    left_out = std::max(left_out, row.expected_s);
  }
  EXPECT_GT(left_out, settings.budget_s / 2) << "what it learned from the cheap ones";
}

TEST(StudyTest, PrecomputeThatWouldNotFitIsRefusedBeforeItStarts) {
  Scenario scenario;
  StudySettings settings{.budget_s = 60, .timing_s = 1e-4};
  scenario.while_making = [&](Progress* progress) {
    progress->Expect({.seconds = 1e4, .memory_bytes = 100});
    if (!progress->Report("factor", 0)) throw Interrupted();
  };
  StudyResult study = RunStudy(fake::Square(), settings, scenario.Make());
  EXPECT_EQ(CountOf(study, Outcome::kSkipped), study.rows.size());
  EXPECT_THAT(study.rows[0].reason, HasSubstr("more than the rest of the budget"));

  scenario.while_making = [&](Progress* progress) {
    progress->Expect({.seconds = 0, .memory_bytes = std::size_t{1} << 40});
    if (!progress->Report("factor", 0)) throw Interrupted();
  };
  study = RunStudy(fake::Square(), settings, scenario.Make());
  EXPECT_THAT(study.rows[0].reason, HasSubstr("of memory"));
}

TEST(StudyTest, FailuresAreRowsWithTheirReason) {
  Scenario scenario;
  scenario.stiffness = [](const Scene& scene) -> double {
    if (scene.model.elements == 60) throw std::invalid_argument("sixty is too many");
    if (scene.model.order == ElementOrder::kLinear) return kUnknown;
    return 100 * (1 - 3.0 / scene.model.elements);
  };
  const StudyResult study = RunStudy(fake::Square(), {.timing_s = 1e-4}, scenario.Make());
  EXPECT_TRUE(study.complete);
  const StudyRow& thrown = RowOf(study, "bem2d constant", "60 elements");
  EXPECT_EQ(thrown.outcome, Outcome::kFailed);
  EXPECT_EQ(thrown.reason, "sixty is too many");
  const StudyRow& refused = RowOf(study, "bem2d linear", "120 elements");
  EXPECT_EQ(refused.outcome, Outcome::kFailed);
  EXPECT_EQ(refused.reason, "spring broke");
  EXPECT_EQ(RowOf(study, "bem2d quadratic", "120 elements").outcome, Outcome::kAnswered);
}

TEST(StudyTest, AStopKeepsTheResultsSoFar) {
  Scenario scenario;
  std::stop_source stop;
  int seen = 0;
  const StudyWatcher watcher{[&](const StudyResult& so_far) {
                               if (++seen == 5) stop.request_stop();
                               EXPECT_GE(so_far.rows.size(), 1U);
                             },
                             nullptr};
  const StudyResult study =
      RunStudy(fake::Square(), {.timing_s = 1e-4}, scenario.Make(), stop.get_token(), watcher);
  EXPECT_FALSE(study.complete);
  EXPECT_EQ(CountOf(study, Outcome::kAnswered), 5U);
  EXPECT_EQ(study.rows.back().reason, "interrupted");
  EXPECT_EQ(scenario.made, 5);
}

}  // namespace
}  // namespace palpate::study
