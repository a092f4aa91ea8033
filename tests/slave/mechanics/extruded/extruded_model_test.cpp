#include "slave/mechanics/extruded/extruded_model.h"

#include <array>
#include <chrono>
#include <cmath>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/reference/planar/patch_solution.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// A block of 100 mm and 10 kPa that is held at its bottom. `tool` and `rest` end the maps.
std::string ExtrudedScene(double height_mm, double thickness_mm, double nu, const std::string& tool,
                          const std::string& kind = "extruded") {
  return "name: block\nobject:\n  geometry: {rectangle: {width: 100 mm, height: " +
         std::to_string(height_mm) + " mm, thickness: " + std::to_string(thickness_mm) +
         " mm}}\n  material: {young_modulus: 10 kPa, poisson_ratio: " + std::to_string(nu) +
         "}\n  fixed: {side: bottom}\ntool: {" + tool + "}\nmodel: {kind: " + kind +
         ", elements: 80}\n";
}

struct ExtrudedBlock {
  explicit ExtrudedBlock(const std::string& text)
      : scene(ParseScene(text)),
        mesh(MeshObject(scene, std::nullopt)),
        model(MakeModel(scene, mesh)) {}

  ContactResponse Press(double x, double y, double depth, double dx = 0) {
    Contact contact;
    contact.p_O = {x, y, 0};
    contact.width = scene.tool->width;
    contact.prescribed_O = {dx, -depth, 0};
    return ToolPress(scene, *scene.tool, mesh).Press(contact, model.get(), &solution);
  }

  Scene scene;
  ObjectMesh mesh;
  std::unique_ptr<DeformationModel> model;
  Solution solution;
};

struct MeasuredStiffness {
  // Relative to the side of 100 mm; behind < 0: the centre.
  double thickness, x, width, depth, behind, nu;
  double stiffness;  // relative to E and the side
};

// Reference: trilinear hexahedra with mean dilatation (block_flat of
// tests/campaigns/truth/pressed_plane.py), graded to the tool's ends, with 6 and 10 across the tool
// and extrapolated. They share nothing with the model. Tolerance: 3 %, of which 1 % is the
// reference's error (for another block the compliance of the half-space was 0.5 % higher).
TEST(ExtrudedModel, IsAsStiffAsBricksInSpace) {
  for (const MeasuredStiffness& at : {MeasuredStiffness{1, 0.5, 0.1, 0.1, -1, 0.45, 0.14403},
                                      MeasuredStiffness{1, 0.5, 0.1, 1, -1, 0.49, 0.53885},
                                      MeasuredStiffness{0.3, 0.5, 0.1, 0.15, -1, 0.3, 0.11687},
                                      MeasuredStiffness{0.6, 0.3, 0.15, 0.12, 0.06, 0.45, 0.14826},
                                      MeasuredStiffness{0.3, 0.5, 0.15, 0.15, 0, 0.49, 0.12823}}) {
    const std::string place =
        at.behind < 0 ? "" : ", behind: " + std::to_string(100 * at.behind) + " mm";
    ExtrudedBlock block(ExtrudedScene(100, 100 * at.thickness, at.nu,
                                      "width: " + std::to_string(100 * at.width) + " mm, depth: " +
                                          std::to_string(100 * at.depth) + " mm" + place));
    const ContactResponse response = block.Press(0.1 * at.x, 0.1, 1e-3);
    ASSERT_EQ(response.validity, Validity::kValid) << response.flag_reason;
    const double force = 1e4 * 0.1 * 1e-3 * at.stiffness;
    EXPECT_NEAR(-response.force_O.y() / force, 1, 0.03) << "T/W " << at.thickness;
  }
}

// Reference: quadratic triangles in plane stress, as in the simulator. The sheet's thickness is a
// hundredth of its width and the tool presses over the whole thickness. Under a bonded tool the
// sheet cannot become thicker; this effect reaches as deep as the thickness. Tolerance: 2 %.
TEST(ExtrudedModel, AThinSheetIsInPlaneStress) {
  ExtrudedBlock sheet(ExtrudedScene(100, 1, 0.3, "width: 10 mm, depth: whole"));
  const simulation::TrueBody body(sheet.scene);
  const auto plane =
      simulation::SolvePatch(body, 0.3, Plane::kStress, body.Nearest({0.05, 0.1}), 0.01);
  const ContactResponse response = sheet.Press(0.05, 0.1, 1e-3);
  const double Et = 1e4 * 1e-3;
  EXPECT_NEAR(response.stiffness_O(1, 1) / (Et * plane.stiffness(1, 1)), 1, 0.02);
  EXPECT_NEAR(response.stiffness_O(0, 0) / (Et * plane.stiffness(0, 0)), 1, 0.02);
}

// Reference: boundary elements in plane stress, which share nothing with these finite elements.
// Tolerance: 3 % of the tool's motion, 2 % for the thickness (see above) and 1 % for 80 elements.
TEST(ExtrudedModel, TheInsideOfAThinSheetMovesAsBoundaryElementsSay) {
  ExtrudedBlock sheet(ExtrudedScene(100, 1, 0.3, "width: 10 mm, depth: whole"));
  ExtrudedBlock plane(ExtrudedScene(100, 1, 0.3, "width: 10 mm", "bem2d, order: quadratic"));
  constexpr double kDepth = 1e-3;  // [m]
  std::vector<Eigen::Vector3d> moved, expected;
  for (const auto& [block, u_O] : {std::pair{&sheet, &moved}, std::pair{&plane, &expected}}) {
    ASSERT_NE(block->Press(0.05, 0.1, kDepth).validity, Validity::kFailed);
    block->model->CoverDisplacements(block->solution, u_O);
  }
  ASSERT_EQ(moved.size(), expected.size());
  ASSERT_GT(sheet.model->cover().inside.size(), 100U);
  for (std::size_t i = sheet.model->field_mesh().vertices.size(); i < moved.size(); ++i) {
    EXPECT_LT((moved[i] - expected[i]).head<2>().norm(), 0.03 * kDepth) << i;
  }
}

// Reference: symmetry of the block: places mirrored at its centre, and tools at equal distances
// from the front and from the back. Tolerance: meshes differ, see above; in the second case only by
// the rounding of the layers.
TEST(ExtrudedModel, MirroredToolsHaveMirroredForces) {
  const auto with = [](double behind) {
    return ExtrudedScene(80, 60, 0.4,
                         "width: 12 mm, depth: 15 mm, behind: " + std::to_string(behind) + " mm");
  };
  ExtrudedBlock front(with(5)), back(with(40));
  const ContactResponse left = front.Press(0.03, 0.08, 1e-3, 5e-4);
  const ContactResponse right = front.Press(0.07, 0.08, 1e-3, -5e-4);
  EXPECT_NEAR(left.force_O.x(), -right.force_O.x(), 0.01 * left.force_O.norm());
  EXPECT_NEAR(left.force_O.y(), right.force_O.y(), 0.01 * left.force_O.norm());
  const ContactResponse behind = back.Press(0.03, 0.08, 1e-3, 5e-4);
  EXPECT_NEAR((behind.force_O - left.force_O).norm(), 0, 1e-6 * left.force_O.norm());
}

// By definition: a front edge under the tool moves with it, a front edge in front of the tool moves
// less, and the supported side does not move.
TEST(ExtrudedModel, TheFrontEdgeMovesAsFarAsTheToolIsNear) {
  const auto moved = [](double behind) {
    ExtrudedBlock block(ExtrudedScene(
        100, 60, 0.45, "width: 10 mm, depth: 10 mm, behind: " + std::to_string(behind) + " mm"));
    EXPECT_EQ(block.Press(0.05, 0.1, 2e-3).validity, Validity::kValid);
    std::vector<Eigen::Vector3d> u_O;
    block.model->Displacements(block.solution, &u_O);
    const auto& mesh = std::get<BoundaryMesh>(block.mesh);
    double top = 0;
    for (std::size_t i = 0; i < u_O.size(); ++i) {
      const Eigen::Vector2d& p = mesh.elements[i].a;
      if (p.y() < 1e-9) EXPECT_EQ(u_O[i], Eigen::Vector3d(0, 0, 0));
      if ((p - Eigen::Vector2d(0.05, 0.1)).norm() < 1e-6) top = -u_O[i].y() / 2e-3;
    }
    return top;
  };
  const double at_front = moved(0), near = moved(5), middle = moved(25);
  EXPECT_NEAR(at_front, 1, 1e-9);
  EXPECT_LT(near, 0.7);
  EXPECT_LT(middle, 0.6 * near);
  EXPECT_GT(middle, 0);
}

TEST(ExtrudedModel, ALoadMovesTheToolAsTheForceOfThatMotionAsks) {
  ExtrudedBlock block(ExtrudedScene(100, 60, 0.45, "width: 10 mm, depth: 10 mm"));
  const ContactResponse pressed = block.Press(0.05, 0.1, 2e-3, 1e-3);
  Contact load;
  load.kind = Contact::Kind::kForce;
  load.p_O = {0.05, 0.1, 0};
  load.width = 0.01;
  load.prescribed_O = pressed.force_O;
  ContactResponse moved;
  block.model->Respond(std::span(&load, 1), std::span(&moved, 1));
  EXPECT_NEAR((moved.displacement_O - Eigen::Vector3d(1e-3, -2e-3, 0)).norm(), 0, 1e-12);
}

TEST(ExtrudedModel, WhatItCannotAnswerFailsWithAReason) {
  ExtrudedBlock block(ExtrudedScene(100, 60, 0.45, "width: 10 mm, depth: 10 mm"));
  EXPECT_EQ(block.Press(0.05, 0, 1e-3).validity, Validity::kFailed);
  EXPECT_THAT(std::string(block.model->failure()), HasSubstr("held"));
  std::array<Contact, 2> two;
  two[0].p_O = {0.03, 0.1, 0};
  two[1].p_O = {0.07, 0.1, 0};
  std::array<ContactResponse, 2> responses;
  block.model->Respond(two, responses);
  EXPECT_EQ(responses[0].validity, Validity::kFailed);
  EXPECT_EQ(block.Press(0.05, 0.1, 0.011).validity, Validity::kExtrapolated);  // of 100 mm
}

// A query must not wait for a new place: it gets the answer of the nearest known one, flagged,
// until another thread has solved it. Reference: a model that solves in the query. The block's top
// is even, so that the neighbour's force is near.
TEST(ExtrudedModel, ANewPlaceIsFlaggedUntilAnotherThreadHasSolvedIt) {
  const std::string scene = ExtrudedScene(100, 60, 0.45, "width: 10 mm, depth: 10 mm");
  ExtrudedBlock live(scene), waiting(scene);
  ASSERT_EQ(live.Press(0.05, 0.1, 1e-3).validity, Validity::kValid);
  live.model->SolveAside();
  EXPECT_EQ(live.Press(0.05, 0.1, 1e-3).validity, Validity::kValid) << "a known place";
  const ContactResponse expected = waiting.Press(0.06, 0.1, 1e-3);
  ContactResponse first = live.Press(0.06, 0.1, 1e-3), last = first;
  EXPECT_EQ(first.validity, Validity::kExtrapolated);
  EXPECT_EQ(first.flag_reason, kBeingComputed);
  EXPECT_LT((first.force_O - expected.force_O).norm(), 0.1 * expected.force_O.norm());
  while (last.flag_reason == kBeingComputed) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    last = live.Press(0.06, 0.1, 1e-3);
  }
  EXPECT_EQ(last.validity, Validity::kValid);
  EXPECT_EQ(last.force_O, expected.force_O);
}

// Reference: contracts, keys of a tool.
TEST(ExtrudedModel, AScenesToolMustBeWithinTheThickness) {
  const auto mistakes = [](const std::string& tool, const std::string& kind = "extruded") {
    return Thrown<SceneError>([&] { ParseScene(ExtrudedScene(100, 60, 0.45, tool, kind)); });
  };
  EXPECT_THAT(mistakes("width: 10 mm"), HasSubstr("tool.depth"));
  EXPECT_THAT(mistakes("width: 10 mm, depth: 10 mm, behind: 51 mm"), HasSubstr("tool.behind"));
  EXPECT_THAT(mistakes("width: 10 mm, depth: 10 mm, shape: round"), HasSubstr("tool.shape"));
  EXPECT_THAT(mistakes("width: 10 mm, depth: 10 mm, behind: 5 mm", "bem2d"),
              HasSubstr("tool.behind"));
  const Scene scene =
      ParseScene(ExtrudedScene(100, 60, 0.45, "width: 10 mm, depth: 10 mm, behind: 50 mm"));
  EXPECT_EQ(scene.tool->behind, 0.05);
}

}  // namespace
}  // namespace palpate
