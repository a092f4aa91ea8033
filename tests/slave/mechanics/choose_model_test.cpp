// The rules of `model.kind: auto`. Their figures against a study: tests/campaigns.
#include "slave/mechanics/factory/choose_model.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::HasSubstr;

// --- outlines

Scene PressedOutline(double thickness) {
  Scene scene;
  scene.object.geometry = RectangleGeometry{0.06, 0.06, thickness};
  scene.object.material = {.young_modulus = 50e3, .poisson_ratio = 0.45};
  scene.object.fixed = {{FixedSide{"bottom"}}};
  scene.tool = Tool{.width = 0.006, .depth = std::numeric_limits<double>::infinity()};
  scene.model.tolerance = 0.1;
  return scene;
}

// Reference: bricks in space, plane_thickness.py: at a tenth of the thickness plane stress has
// three times the force, and 3 % too little on a thin sheet.
TEST(ChooseModelTest, AStickOnACubeIsExtrudedAndAWholeToolOnASheetIsPlane) {
  Scene cube = PressedOutline(0.06);
  cube.tool->depth = 0.006;
  EXPECT_EQ(ChooseModel(cube).model.kind, "extruded");
  EXPECT_THAT(ChooseModel(cube).reason, HasSubstr("beyond the tolerance of 10 %"));
  EXPECT_EQ(ChooseModel(PressedOutline(0.002)).model.kind, "bem2d");
}

// Extruded bodies are glued to a flat tool.
TEST(ChooseModelTest, WhatExtrudedCannotComputeStaysPlane) {
  Scene sliding = PressedOutline(0.06), round = PressedOutline(0.06),
        unknown = PressedOutline(0.06);
  sliding.model.contact = ContactLaw::kFrictionless;
  round.tool->shape = Tool::Shape::kRound;
  round.tool->radius = 0.003;
  unknown.tool->depth.reset();
  for (const Scene& scene : {sliding, round, unknown}) {
    EXPECT_EQ(ChooseModel(scene).model.kind, "bem2d");
  }
}

TEST(ChooseModelTest, ASmallerToleranceGetsMoreElementsUnderTheTool) {
  Scene scene = PressedOutline(0.001);
  int before = 0;
  for (const double tolerance : {0.2, 0.05, 0.03}) {
    scene.model.tolerance = tolerance;
    const int elements = ChooseModel(scene).model.elements;
    EXPECT_GT(elements, before);
    EXPECT_NEAR(std::remainder(elements / 40.0, 1), 0, 0.05);  // 40 tools around the block
    before = elements;
  }
}

// Constant elements are far too stiff in bending.
TEST(ChooseModelTest, ASlenderOutlineGetsLinearElements) {
  Scene beam = PressedOutline(0.001);
  beam.object.geometry = RectangleGeometry{0.06, 0.008, 0.001};
  EXPECT_EQ(ChooseModel(beam).model.order, ElementOrder::kLinear);
  EXPECT_EQ(ChooseModel(PressedOutline(0.001)).model.order, ElementOrder::kConstant);
}

TEST(ChooseModelTest, NumbersOfFixedElementsKeepTheirMesh) {
  Scene scene = PressedOutline(0.001);
  scene.model.elements = 77;
  scene.object.fixed = {{FixedNodes{{0, 1, 2}}}};
  EXPECT_EQ(ChooseModel(scene).model.elements, 77);
}

// --- membranes

Scene PressedMembraneScene(double depth, double tolerance) {
  Scene scene;
  scene.object.geometry = MembraneGeometry{0.039, 0.001};
  scene.object.material = {.young_modulus = 27.2e6, .poisson_ratio = 0.45};
  scene.operator_options.press_depth = depth;
  scene.operator_options.press_given = true;
  scene.model.tolerance = tolerance;
  return scene;
}

// Reference: paper C's plate is low by 1.8 % at w/t = 0.2, 10 % at 0.5, 30 % at 1 (corrections),
// and its theory ends at t / 2.
TEST(ChooseModelTest, BendsAMembraneOnlyWhereThatIsEnough) {
  EXPECT_EQ(ChooseModel(PressedMembraneScene(0.2e-3, 0.03)).model.kind, "plate");
  EXPECT_EQ(ChooseModel(PressedMembraneScene(0.2e-3, 0.01)).model.kind, "plate-large");
  EXPECT_EQ(ChooseModel(PressedMembraneScene(0.49e-3, 0.12)).model.kind, "plate");
  EXPECT_EQ(ChooseModel(PressedMembraneScene(0.49e-3, 0.08)).model.kind, "plate-large");
  EXPECT_EQ(ChooseModel(PressedMembraneScene(0.51e-3, 1.0)).model.kind, "plate-large");
  EXPECT_EQ(ChooseModel(PressedMembraneScene(5e-3, 0.05)).model.kind, "plate-large");
}

TEST(ChooseModelTest, StatesTheDepthOfAPressOnAMembrane) {
  EXPECT_THAT(
      ChooseModel(PressedMembraneScene(0.2e-3, 0.05)).reason,
      testing::HasSubstr(
          "an indentation of 0.2 thicknesses, where the force of bending alone is 1.8 % too low"));
  EXPECT_THAT(
      ChooseModel(PressedMembraneScene(5e-3, 0.05)).reason,
      testing::HasSubstr(
          "an indentation of 5 thicknesses, where the force of bending alone is far too low"));
  Scene by_default = PressedMembraneScene(5e-3, 0.05);
  by_default.operator_options.press_given = false;
  EXPECT_EQ(ChooseModel(by_default).model.kind, "plate");
  by_default.sense.Set(PointsOptions{});  // two cameras watch the press, however deep by default
  EXPECT_EQ(ChooseModel(by_default).model.kind, "plate-large");
  Scene tight = PressedMembraneScene(0.1e-3, 0.05);
  tight.model.prestress = 12;
  EXPECT_EQ(ChooseModel(tight).model.kind, "plate-large");
}

// --- volumes

Scene PressedBox(double depth, double poisson_ratio) {
  Scene scene;
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.04}, {3, 3, 2}};
  scene.object.material = {.young_modulus = 10e3, .poisson_ratio = poisson_ratio};
  scene.object.fixed = {{FixedPlane{2, 0}}};
  scene.tool = Tool{.width = 0.02};
  scene.operator_options.press_depth = depth;
  scene.model.tolerance = 0.15;
  return scene;
}

TEST(ChooseModelTest, AShallowPressOnAVolumeIsLinearAndADeepOneHasLargeStrains) {
  EXPECT_EQ(ChooseModel(PressedBox(0.001, 0.3)).model.kind, "fem-green");
  const ModelChoice deep = ChooseModel(PressedBox(0.012, 0.3));
  EXPECT_EQ(deep.model.kind, "fem");
  EXPECT_EQ(deep.model.fem.law, FemOptions::Law::kNeoHookean);
}

TEST(ChooseModelTest, LockingNeedsTenNodes) {
  const auto element = [](double depth, double poisson_ratio) {
    return ChooseModel(PressedBox(depth, poisson_ratio)).model.fem.element;
  };
  EXPECT_EQ(element(0.012, 0.3), FemOptions::Element::kTet4);
  EXPECT_EQ(element(0.012, 0.45), FemOptions::Element::kTet10);
  EXPECT_EQ(element(0.001, 0.45), FemOptions::Element::kTet10);
}

TEST(ChooseModelTest, ATightToleranceGetsMoreCellsAndAFineToolFourNodes) {
  Scene tight = PressedBox(0.001, 0.3), fine = tight;
  const ModelChoice usual = ChooseModel(tight);
  EXPECT_EQ(usual.model.fem.element, FemOptions::Element::kTet10);
  tight.model.tolerance = 0.06;
  EXPECT_GT(ChooseModel(tight).cells[0], usual.cells[0]);
  fine.tool->width = 0.006;
  EXPECT_EQ(ChooseModel(fine).model.fem.element, FemOptions::Element::kTet4);
}

TEST(ChooseModelTest, MotionWeightFrictionAndOtherToolsNeedFiniteElements) {
  Scene moving = PressedBox(0.001, 0.3), heavy = moving, rough = moving, capsule = moving;
  moving.model.fem.time = FemOptions::Time::kDynamic;
  heavy.model.fem.gravity_O = {0, 0, -9.81};
  rough.model.contact = ContactLaw::kFriction;
  capsule.tool->shape = Tool::Shape::kCapsule;
  for (const Scene& scene : {moving, heavy, rough, capsule}) {
    EXPECT_EQ(ChooseModel(scene).model.kind, "fem") << ChooseModel(scene).reason;
  }
}

TEST(ChooseModelTest, ANamedModelStaysAsItIs) {
  Scene scene = PressedBox(0.02, 0.49);
  scene.model.kind = "fem-green";
  const Scene same = WithChosenModel(scene);
  EXPECT_EQ(same.model.kind, "fem-green");
  EXPECT_TRUE(same.model.reason.empty());
  EXPECT_EQ(std::get<BoxGeometry>(same.object.geometry).cells[0], 3);
}

}  // namespace
}  // namespace palpate
