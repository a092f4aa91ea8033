#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/green/fem_green_model.h"
#include "slave/reference/planar/round_touch.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/allocation_count.h"
#include "tests/support/fixed_nodes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

ContactResponse Press(const Contact& contact, DeformationModel* model, Solution* solution) {
  model->Solve({&contact, 1}, solution);
  return solution->responses().front();
}
ContactResponse Press(const Contact& contact, DeformationModel* model) {
  Solution solution;
  return Press(contact, model, &solution);
}

// A block in plane strain, 1 m wide and high, E = 1 Pa, held at its bottom.
class Block2d : public testing::Test {
 protected:
  static constexpr double kE = 1, kNu = 0.3, kRadius = 0.4;
  static constexpr int kElements = 800;  // 5 mm long

  Block2d() : mesh_(MeshRectangle(1, 1, kElements)) {}
  // Making a model takes seconds, so each is made once.
  [[nodiscard]] Bem2dModel* Make(ContactLaw law) const {
    static std::map<ContactLaw, std::unique_ptr<Bem2dModel>> made;
    auto& model = made[law];
    if (model) return model.get();
    std::vector<std::array<bool, 2>> held(mesh_.elements.size(), {false, false});
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (mesh_.elements[i].midpoint().y() < 1e-9) held[i] = {true, true};
    }
    model = std::make_unique<Bem2dModel>(
        ReferenceProblem{mesh_, held, kNu, Plane::kStrain, ElementOrder::kConstant},
        Bem2dModel::Params{.young_modulus = kE, .thickness = 1, .contact = law, .range = 0.1});
    return model.get();
  }
  static Contact At(double depth, double radius = kRadius) {
    return {.p_O = {0.5, 1, 0}, .prescribed_O = {0, -depth, 0}, .radius = radius};
  }

  BoundaryMesh mesh_;
};

// Reference: Hertz for a cylinder on a half-plane (Johnson, Contact Mechanics, 4.42 to 4.45): a^2 =
// 4 P R / (pi E*), p0 = 2 P / (pi a). The theory needs a to be much smaller than radius and block:
// here up to 0.05 m compared with 0.4 m and 1 m. Tolerance of a: one element of 5 mm, half at
// either end, and 1 % because the theory approximates the circle by a parabola. Tolerance of p0:
// the mean over the central element differs by 6 % with 4 elements per half width, and by less with
// more.
TEST_F(Block2d, ACylindersContactIsAsWideAndPressesAsHertzHasIt) {
  Bem2dModel* model = Make(ContactLaw::kFrictionless);
  Solution solution;
  const double element = mesh_.elements[0].length(), modulus = kE / (1 - kNu * kNu);
  double last = 0;
  for (const double depth : {0.004, 0.007, 0.011, 0.016}) {
    const ContactResponse response = Press(At(depth), model, &solution);
    ASSERT_EQ(response.validity, Validity::kValid);
    const double P = -response.force_O.y();
    const double a = std::sqrt(4 * P * kRadius / (std::numbers::pi * modulus));
    EXPECT_LT(a, 0.07) << "Hertz' range";
    EXPECT_GT(a, last) << "the contact grows with the depth";
    EXPECT_NEAR(0.5 * response.touching * element, a, element + 0.01 * a) << depth;
    double p0 = 0;
    for (const auto& traction : model->Boundary(solution).traction) {
      p0 = std::max(p0, -traction.y());
    }
    EXPECT_NEAR(p0 / (2 * P / (std::numbers::pi * a)), 1, 0.06) << depth;
    last = a;
  }
}

// Reference: complementarity. No traction is tensile, and no free vertex of the outline is inside
// the tool, by the model's own displacements, to a hundredth of the depth (constant elements
// interpolate vertices by straight lines between midpoints). As usual in linear contact, the
// distance from the tool's axis is that of the undeformed surface.
TEST_F(Block2d, NoPlaceIsPulledOrInsideTheTool) {
  for (const auto law : {ContactLaw::kFrictionless, ContactLaw::kBonded}) {
    Bem2dModel* model = Make(law);
    Solution solution;
    const double depth = 0.02;
    ASSERT_EQ(Press(At(depth), model, &solution).validity, Validity::kValid);
    const BoundaryState state = model->Boundary(solution);
    for (std::size_t i = 0; i < mesh_.elements.size(); ++i) {
      if (mesh_.elements[i].midpoint().y() < 1 - 1e-9) continue;
      EXPECT_LE(state.traction[i].y(), 1e-9) << "element " << i;
    }
    std::vector<Vector3d> u;
    model->Displacements(solution, &u);
    for (std::size_t i = 0; i < u.size(); ++i) {
      const Eigen::Vector2d p = mesh_.elements[i].a + u[i].head<2>();
      const double rho = mesh_.elements[i].a.x() - 0.5;
      if (mesh_.elements[i].a.y() < 1 - 1e-9 || std::abs(rho) >= kRadius) continue;
      const double tool_y = 1 - depth + kRadius - std::sqrt(kRadius * kRadius - rho * rho);
      EXPECT_LT(p.y(), tool_y + 0.01 * depth) << "vertex " << i;
    }
  }
}

// Reference: the difference of two presses, 1e-3 apart. The touched elements hardly change between
// them.
TEST_F(Block2d, TheStiffnessIsTheForcesSlope) {
  for (const auto law : {ContactLaw::kFrictionless, ContactLaw::kBonded}) {
    Bem2dModel* model = Make(law);
    const double depth = 0.02, step = 1e-5;
    const ContactResponse here = Press(At(depth), model);
    const ContactResponse deeper = Press(At(depth + step), model);
    const double slope = -(deeper.force_O - here.force_O).y() / step;
    EXPECT_NEAR(here.stiffness_O(1, 1) / slope, 1, 0.03);
  }
}

// Reference: symmetry. The softer side, towards the block's corner, bears less.
TEST_F(Block2d, TheMomentIsThatOfThePressureWhereItActs) {
  Bem2dModel* model = Make(ContactLaw::kFrictionless);
  Contact at = At(0.016);
  const ContactResponse centre = Press(at, model);
  ASSERT_TRUE(centre.moment_O);
  EXPECT_NEAR(centre.moment_O->z(), 0, 1e-6 * kRadius * centre.force_O.norm());
  at.p_O.x() = 0.93;
  const ContactResponse beside = Press(at, model);
  ASSERT_TRUE(beside.moment_O);
  const double offset = beside.moment_O->z() / beside.force_O.y();
  EXPECT_LT(offset, -0.5e-3) << "the centre of pressure lies inwards of the tip";
  EXPECT_GT(offset, -0.07) << "and under the tool";
}

TEST_F(Block2d, ATouchThatTheMeshCannotShowIsNotValidAndAnAbsentOneHasNoForce) {
  Bem2dModel* model = Make(ContactLaw::kBonded);
  const ContactResponse shallow = Press(At(1e-4, 0.01), model);
  EXPECT_EQ(shallow.validity, Validity::kExtrapolated);
  EXPECT_FALSE(shallow.flag_reason.empty());
  const ContactResponse away = Press(At(-0.01, 0.01), model);
  EXPECT_EQ(away.validity, Validity::kValid);
  EXPECT_EQ(away.force_O.norm(), 0);
  EXPECT_GT(away.stiffness_O(1, 1), 0);
  for (const double bad : {std::nan(""), -1.0, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(Press(At(0.01, bad), model).validity, Validity::kFailed) << bad;
  }
  EXPECT_EQ(Press(At(std::nan("")), model).validity, Validity::kFailed);
}

// By definition: a query of a known size, with the same or another number of places that touch.
TEST_F(Block2d, AnUpdateOfAToolDoesNotAllocate) {
  Bem2dModel* model = Make(ContactLaw::kBonded);
  ContactResponse response;
  const auto press = [&](double depth) {
    const Contact contact = At(depth);
    model->Respond({&contact, 1}, {&response, 1});
  };
  press(0.02);
  press(0.01);
  const long before = AllocationCount();
  for (const double depth : {0.02, 0.019, 0.005, 0.0, -0.001, 0.012, 0.02}) press(depth);
  EXPECT_EQ(AllocationCount(), before);
  EXPECT_EQ(response.validity, Validity::kValid);
}

// A flat tool of 10 mm on a disc of 20 mm. It first touches in one point; glued to the outline at
// once it would be 3.3 times too stiff at 0.1 mm. Reference: quadratic finite elements whose nodes
// touch one by one. Tolerance: one element more or less where few touch.
TEST(FlatToolOnADisc, TouchesOnlyWhatItReaches) {
  for (const auto& [elements, order] : {std::pair{200, "constant"}, {200, "linear"}}) {
    const Scene scene = ParseScene(
        "name: disc\nobject:\n  geometry: {disc: {radius: 20 mm, thickness: 1 mm}}\n"
        "  material: {young_modulus: 20 kPa, poisson_ratio: 0.3}\n"
        "  fixed: {arc: {centre: 270 deg, half_angle: 40 deg}}\n"
        "tool: {width: 10 mm, depth: whole}\n"
        "model: {kind: bem2d, plane: stress, elements: " +
        std::to_string(elements) + ", order: " + order + "}\n");
    const simulation::TrueBody body(scene);
    const auto truth = simulation::SolveUnderRound(body, 0.3, Plane::kStress,
                                                   body.Nearest({0, 0.02}), *scene.tool);
    const ObjectMesh mesh = MeshObject(scene, std::nullopt);
    const auto model = MakeModel(scene, mesh);
    for (const auto& [depth, tolerance] : {std::pair{1e-4, 0.06}, {3e-4, 0.03}, {1e-3, 0.03}}) {
      const ContactResponse response =
          Press({.p_O = {0, 0.02, 0}, .width = 0.01, .prescribed_O = {0, -depth, 0}}, model.get());
      const double force =
          20 * simulation::Touched(*truth.round, {0, -depth}, 0).total().y();  // E t = 20 N/m
      EXPECT_NEAR(response.force_O.y() / force, 1, tolerance) << depth << ' ' << order;
    }
  }
}

// Reference: Hertz for a sphere on a half-space, F = 4/3 E* sqrt(R) d^1.5, a = sqrt(R d) (Johnson,
// 4.22 to 4.24). The half-space is a block of 1 m, E = 1 Pa, held at its bottom, with small cells
// about the middle of its top; radius 0.4 m, contacts of up to 7 cm: a bottom that far away makes
// them 6 % stiffer at most (Dimitriadis et al., Biophys. J. 82, 2002).
struct Sphere3d {
  static constexpr double kNu = 0.3, kRadius = 0.4;
  static double Force(double depth) {
    return 4.0 / 3 / (1 - kNu * kNu) * std::sqrt(kRadius) * std::pow(depth, 1.5);
  }
  static Contact At(double depth) {
    return {.p_O = {0.5, 0.5, 1}, .prescribed_O = {0, 0, -depth}, .radius = kRadius};
  }
};

SolidMesh GradedBlock(const std::array<int, 3>& cells) {
  SolidMesh mesh = MeshBox({1, 1, 1}, cells);
  const auto towards_zero = [](double t) { return t * (0.15 + 0.85 * t * t); };
  for (Vector3d& p : mesh.nodes) {
    p.x() = 0.5 + 0.5 * towards_zero(2 * p.x() - 1);
    p.y() = 0.5 + 0.5 * towards_zero(2 * p.y() - 1);
    p.z() = 1 - towards_zero(1 - p.z());
  }
  return mesh;
}

// The contact is resolved node by node with finite elements. Tolerance: 15 %, also because
// four-node tetrahedra are too stiff where the strain varies.
TEST(RoundTool3d, ASpheresForceOnFiniteElementsIsHertzs) {
  const SolidMesh solid = GradedBlock({18, 18, 14});
  const HeldNodes held = FixedWhere(solid, [](const Vector3d& p) { return p.z() < 1e-9; });
  FemGreenModel model(solid, held, 1, Sphere3d::kNu, {.contact = ContactLaw::kFrictionless});
  for (const double depth : {0.007, 0.012}) {
    const ContactResponse response = Press(Sphere3d::At(depth), &model);
    ASSERT_NE(response.validity, Validity::kFailed) << model.failure();
    EXPECT_NEAR(-response.force_O.z() / Sphere3d::Force(depth), 1, 0.15) << depth;
  }
}

}  // namespace
}  // namespace palpate
