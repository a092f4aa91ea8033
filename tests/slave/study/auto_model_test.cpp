#include "slave/study/auto_model.h"

#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/study/fake_model_factory.h"

namespace palpate::study {
namespace {

using testing::HasSubstr;

// Linear elements are twice as accurate as constant ones, quadratic ones expensive.
fake::Scenario Orders() {
  fake::Scenario scenario;
  scenario.stiffness = [](const Scene& scene) {
    const bool constant = scene.model.order == ElementOrder::kConstant;
    return 100 * (1 - (constant ? 6.0 : 3.0) / scene.model.elements);
  };
  scenario.precompute = [](const Scene& scene) {
    const bool quadratic = scene.model.order == ElementOrder::kQuadratic;
    return 1e-5 * scene.model.elements * (quadratic ? 8 : 1);
  };
  return scenario;
}

Scene Auto(double tolerance) {
  Scene scene = fake::Square();
  scene.model.kind = "auto";
  scene.model.tolerance = tolerance;
  return scene;
}

// Linear elements have an error of 3 / count: 60 are the coarsest within 6 %. Constant elements
// need 120, which cost more.
TEST(AutoModelTest, TakesTheCheapestKindAndResolutionThatMeetsTolerance) {
  fake::Scenario scenario = Orders();
  const auto decided = DecideQuickly(Auto(0.06), scenario.Make());
  ASSERT_TRUE(decided);
  EXPECT_EQ(decided->model.kind, "bem2d");
  EXPECT_EQ(decided->model.order, ElementOrder::kLinear);
  EXPECT_EQ(decided->model.elements, 60);
  const ModelDecision& decision = decided->model.decision;
  EXPECT_TRUE(decision.meets);
  EXPECT_NEAR(decision.error, 0.05, 0.002);
  EXPECT_THAT(decision.reason, HasSubstr("bem2d linear, 60 elements"));
  EXPECT_THAT(decision.reason, HasSubstr("5 % error"));
}

TEST(AutoModelTest, ReportsRejectedModelsWithTheirFigures) {
  fake::Scenario scenario = Orders();
  const auto decided = DecideQuickly(Auto(0.06), scenario.Make());
  ASSERT_TRUE(decided);
  const auto& rejected = decided->model.decision.rejected;
  const auto found =
      std::ranges::find(rejected, "bem2d constant, 60 elements", &RejectedModel::model);
  ASSERT_NE(found, rejected.end());
  EXPECT_THAT(found->why, HasSubstr("misses the tolerance of 6 %"));
  EXPECT_NEAR(found->error, 0.1, 0.004);
  EXPECT_NEAR(found->precompute, 60e-5, 1e-9);
}

TEST(AutoModelTest, SaysWhatCannotBeMetAndTheNearestThatCan) {
  fake::Scenario scenario = Orders();
  Scene scene = Auto(1e-4);
  scene.model.rate = 1e9;
  const auto decided = DecideQuickly(scene, scenario.Make());
  ASSERT_TRUE(decided);
  EXPECT_FALSE(decided->model.decision.meets);
  const std::string& reason = decided->model.decision.reason;
  EXPECT_THAT(reason, HasSubstr("none is within 0.01 %, the nearest is bem2d"));
  EXPECT_THAT(reason, HasSubstr("none reaches 1e+09 Hz, the nearest is bem2d"));
}

TEST(AutoModelTest, WithoutAnAnswerInTimeNothingIsDecided) {
  fake::Scenario scenario = Orders();
  scenario.stiffness = [](const Scene&) { return kUnknown; };
  EXPECT_FALSE(DecideQuickly(Auto(0.05), scenario.Make()));
  scenario.while_making = [](Progress* progress) {
    progress->Expect({.seconds = 100, .memory_bytes = 0});
    if (!progress->Report("factor", 0)) throw Interrupted();
  };
  EXPECT_FALSE(DecideQuickly(Auto(0.05), scenario.Make()));
}

// With the clock of a machine that is a hundred times slower, the same models are tried and the
// same one is chosen, if the required rate is low enough.
TEST(AutoModelTest, ASlowMachineChoosesTheSame) {
  std::vector<std::string> choices;
  for (const double slower : {1.0, 100.0}) {
    fake::Scenario scenario = Orders();
    scenario.precompute = [=](const Scene& scene) {
      return slower * 1e-9 * std::pow(scene.model.elements, 3);
    };
    Scene scene = Auto(0.05);
    scene.model.rate = 1;
    const auto decided = DecideQuickly(scene, scenario.Make());
    ASSERT_TRUE(decided);
    choices.push_back(decided->model.kind + " " + std::to_string(decided->model.elements) + " of " +
                      std::to_string(decided->model.decision.rejected.size()));
  }
  EXPECT_EQ(choices[0], choices[1]);
}

// --- real models

Scene AutoCube() {
  Scene scene = fake::Square();
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.06}, {3, 3, 3}};
  scene.object.fixed = {{FixedPlane{2, 0}, {true, true, true}}};
  scene.model.contact = ContactLaw::kBonded;
  scene.model.kind = "auto";
  scene.model.tolerance = 0.5;
  scene.tool->width = 0.02;
  scene.operator_options.press_depth = 0.002;
  scene.study_contacts = {{0.03, 0.03, 0.06}};  // the reference at several places takes seconds
  return scene;
}

// A condensed model has neither mass nor weight, whatever its parameters.
TEST(AutoModelTest, MotionAndWeightNeedFiniteElements) {
  Scene moving = AutoCube(), heavy = AutoCube();
  moving.model.fem.time = FemOptions::Time::kDynamic;
  heavy.model.fem.gravity_O = {0, 0, -9.81};
  for (const Scene& scene : {moving, heavy}) {
    const auto decided = DecideQuickly(scene, DefaultModelFactory(), 1);
    ASSERT_TRUE(decided);
    EXPECT_THAT(decided->model.kind, testing::StartsWith("fem"));
    EXPECT_NE(decided->model.kind, "fem-green");
    EXPECT_EQ(decided->model.fem.time, scene.model.fem.time);
    EXPECT_EQ(decided->model.fem.gravity_O, scene.model.fem.gravity_O);
    const auto& rejected = decided->model.decision.rejected;
    EXPECT_TRUE(std::ranges::any_of(rejected, [](const RejectedModel& one) {
      return one.why == "is not dynamic" || one.why == "has no gravity";
    }));
  }
}

// Reference: bricks in space, plane_thickness.py: at b/T = 0.1 and nu = 0.49 plane stress has
// 3.276 times the force. Tolerance: 5 %, of both discretisations.
TEST(AutoModelTest, AStickOnACubeIsAnExtrudedOutlineAndAWholeToolOnASheetIsNot) {
  Scene cube = fake::Square();
  cube.object.geometry = RectangleGeometry{0.06, 0.06, 0.06};
  cube.object.fixed = {{FixedSide{"bottom"}, {true, true, true}}};
  cube.model.kind = "auto";
  cube.model.contact = ContactLaw::kBonded;
  cube.model.tolerance = 0.1;
  cube.model.elements = 540;
  cube.object.material.poisson_ratio = 0.49;
  cube.tool = Tool{.width = 0.004, .depth = 0.006};
  const auto decided = DecideOnThickness(cube);
  ASSERT_TRUE(decided);
  EXPECT_EQ(decided->model.kind, "extruded");
  EXPECT_TRUE(decided->model.decision.meets);
  const std::string& reason = decided->model.decision.reason;
  const std::string before = "plane stress has ";
  ASSERT_THAT(reason, HasSubstr(before));
  EXPECT_NEAR(std::stod(reason.substr(reason.find(before) + before.size())), 3.276, 0.16);
  Scene sheet = cube;
  sheet.object.geometry = RectangleGeometry{0.06, 0.06, 0.002};
  sheet.tool->depth = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(DecideOnThickness(sheet));
}

}  // namespace
}  // namespace palpate::study
