#include "slave/mechanics/indenter/round_indenter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/fem/green/fem_green_model.h"
#include "tests/support/fixed_nodes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

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
  static ToolIndentation At(double depth) { return {{0.5, 1, 0}, {0, 1, 0}, {0, -depth, 0}}; }

  BoundaryMesh mesh_;
};

double HalfWidth(const Solution& solution, double element) {
  double least = 1e9, most = -1e9;
  for (const Contact& at : solution.contacts()) {
    least = std::min(least, at.p_O.x());
    most = std::max(most, at.p_O.x());
  }
  return 0.5 * (most - least + element);
}

// Reference: Hertz for a cylinder on a half-plane (Johnson, Contact Mechanics, 4.42 to 4.45): a^2 =
// 4 P R / (pi E*), p0 = 2 P / (pi a). The theory needs a to be much smaller than radius and block:
// here up to 0.05 m compared with 0.4 m and 1 m. Tolerance of a: one element of 5 mm, half at
// either end, and 1 % because the theory approximates the circle by a parabola. Tolerance of p0:
// the mean over the central element differs by 6 % with 4 elements per half width, and by less with
// more.
TEST_F(Block2d, ACylindersContactIsAsWideAndPressesAsHertzHasIt) {
  Bem2dModel* model = Make(ContactLaw::kFrictionless);
  RoundIndenter tool(TouchablePlaces(mesh_), kRadius, ContactLaw::kFrictionless);
  Solution solution;
  const double element = mesh_.elements[0].length(), modulus = kE / (1 - kNu * kNu);
  double last = 0;
  for (const double depth : {0.004, 0.007, 0.011, 0.016}) {
    const ContactResponse response = tool.Press(At(depth), model, &solution);
    ASSERT_EQ(response.validity, Validity::kValid);
    const double P = -response.force_O.y();
    const double a = std::sqrt(4 * P * kRadius / (std::numbers::pi * modulus));
    EXPECT_LT(a, 0.07) << "Hertz' range";
    EXPECT_GT(a, last) << "the contact grows with the depth";
    EXPECT_NEAR(HalfWidth(solution, element), a, element + 0.01 * a) << depth;
    double p0 = 0;
    for (const ContactResponse& part : solution.responses()) {
      p0 = std::max(p0, -part.force_O.y() / element);
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
    RoundIndenter tool(TouchablePlaces(mesh_), kRadius, law);
    Solution solution;
    const double depth = 0.02;
    ASSERT_EQ(tool.Press(At(depth), model, &solution).validity, Validity::kValid);
    for (const ContactResponse& part : solution.responses()) EXPECT_LE(part.force_O.y(), 0);
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

// Reference: the difference of two presses, 1e-3 apart; the touched elements hardly change between
// them.
TEST_F(Block2d, TheStiffnessIsTheForcesSlope) {
  for (const auto law : {ContactLaw::kFrictionless, ContactLaw::kBonded}) {
    Bem2dModel* model = Make(law);
    RoundIndenter tool(TouchablePlaces(mesh_), kRadius, law);
    Solution solution;
    const double depth = 0.02, step = 1e-5;
    const ContactResponse here = tool.Press(At(depth), model, &solution);
    const ContactResponse deeper = tool.Press(At(depth + step), model, &solution);
    const double slope = -(deeper.force_O - here.force_O).y() / step;
    EXPECT_NEAR(here.stiffness_O(1, 1) / slope, 1, 0.03);
  }
}

// Reference: the difference of two presses that the same nodes touch, 1 % of the depth apart, at a
// quarter of the cube's height.
TEST(LargePressTest, TheStiffnessIsTheForcesSlopeAtItsDepth) {
  constexpr double kSide = 0.04, kRadius = 0.015, kDepth = 0.010, kStep = 0.01 * kDepth;
  for (const auto law : {FemOptions::Law::kCorotational, FemOptions::Law::kNeoHookean}) {
    Scene scene;
    scene.object.geometry = BoxGeometry{Vector3d::Constant(kSide), {8, 8, 8}};
    scene.object.material.young_modulus = 4000;
    scene.object.material.poisson_ratio = 0.3;
    scene.object.fixed = {Fixed{FixedPlane{2, 0}}};
    scene.model.kind = "fem";
    scene.model.fem.law = law;
    scene.model.range = 0.5;
    scene.model.contact = ContactLaw::kFrictionless;
    const ObjectMesh mesh = MeshObject(scene, std::nullopt);
    const auto model = MakeModel(scene, mesh);
    const SurfaceMesh surface = SurfaceOf(std::get<SolidMesh>(mesh));
    RoundIndenter tool(TouchableNodes(surface), kRadius, ContactLaw::kFrictionless);
    Solution solution;
    const auto press = [&](double depth) {
      return tool.Press({{kSide / 2, kSide / 2, kSide}, {0, 0, 1}, {0, 0, -depth}}, model.get(),
                        &solution);
    };
    for (double depth = 0.002; depth < kDepth; depth += 0.002) press(depth);
    const ContactResponse here = press(kDepth);
    ASSERT_NE(here.validity, Validity::kFailed);
    const std::size_t touching = solution.contacts().size();
    const double deeper = press(kDepth + kStep).force_O.z();
    ASSERT_EQ(solution.contacts().size(), touching);
    const double slope = (here.force_O.z() - deeper) / kStep;
    EXPECT_NEAR(here.stiffness_O(2, 2) / slope, 1, 0.02);
  }
}

// Reference: symmetry. The softer side, towards the block's corner, bears less. The moment about
// another point differs by the moment of the whole force.
TEST_F(Block2d, TheMomentIsThatOfThePressureWhereItActs) {
  Bem2dModel* model = Make(ContactLaw::kFrictionless);
  RoundIndenter tool(TouchablePlaces(mesh_), kRadius, ContactLaw::kFrictionless);
  Solution solution;
  ToolIndentation at = At(0.016);
  const Vector3d tip = at.p_O + at.displacement_O;
  const Vector3d force = tool.Press(at, model, &solution).force_O;
  EXPECT_NEAR(MomentAbout(solution, tip).z(), 0, 1e-6 * kRadius * force.norm());
  const Vector3d aside(0.1, -0.03, 0);
  EXPECT_NEAR(
      (MomentAbout(solution, tip + aside) - MomentAbout(solution, tip) + aside.cross(force)).norm(),
      0, 1e-9 * force.norm());
  at.p_O.x() = 0.93;
  const Vector3d beside = tool.Press(at, model, &solution).force_O;
  const double offset = MomentAbout(solution, at.p_O + at.displacement_O).z() / beside.y();
  EXPECT_LT(offset, -0.5e-3) << "the centre of pressure lies inwards of the tip";
  EXPECT_GT(offset, -0.07) << "and under the tool";
}

// Reference: on a straight face only the position of the circle matters. A tool that has rolled
// gives the same answer as one that touched first at its present centre, to rounding.
TEST_F(Block2d, AToolThatHasRolledPressesBelowItsCentre) {
  Bem2dModel* model = Make(ContactLaw::kBonded);
  RoundIndenter tool(TouchablePlaces(mesh_), kRadius, ContactLaw::kBonded);
  Solution solution;
  ToolIndentation rolled = At(0.016), beside = At(0.016);
  rolled.displacement_O.x() = beside.displacement_O.x() = 0.003;
  rolled.rolled_O = {-0.02, 0, 0};
  beside.p_O.x() += 0.02;
  const ContactResponse one = tool.Press(rolled, model, &solution);
  const ContactResponse other = tool.Press(beside, model, &solution);
  const ContactResponse straight = tool.Press(At(0.016), model, &solution);
  EXPECT_LT((one.force_O - other.force_O).norm(), 1e-9 * other.force_O.norm());
  EXPECT_GT((one.force_O - straight.force_O).norm(), 1e-3 * straight.force_O.norm());
}

TEST_F(Block2d, ATouchThatTheMeshCannotShowIsNotValidAndAnAbsentOneHasNoForce) {
  Bem2dModel* model = Make(ContactLaw::kBonded);
  RoundIndenter tool(TouchablePlaces(mesh_), 0.01, ContactLaw::kBonded);
  Solution solution;
  const ContactResponse shallow = tool.Press(At(1e-4), model, &solution);
  EXPECT_EQ(shallow.validity, Validity::kExtrapolated);
  EXPECT_FALSE(shallow.flag_reason.empty());
  const ContactResponse away = tool.Press(At(-0.01), model, &solution);
  EXPECT_EQ(away.validity, Validity::kValid);
  EXPECT_EQ(away.force_O.norm(), 0);
  EXPECT_GT(away.stiffness_O(1, 1), 0);
  EXPECT_EQ(tool.Press(At(std::nan("")), model, &solution).validity, Validity::kFailed);
  EXPECT_THROW(RoundIndenter(TouchablePlaces(mesh_), 0, ContactLaw::kBonded),
               std::invalid_argument);
  EXPECT_THROW(RoundIndenter({}, 1, ContactLaw::kBonded), std::invalid_argument);
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
  static ToolIndentation At(double depth) { return {{0.5, 0.5, 1}, {0, 0, 1}, {0, 0, -depth}}; }
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
TEST(RoundIndenter3d, ASpheresForceOnFiniteElementsIsHertzs) {
  const SolidMesh solid = GradedBlock({18, 18, 14});
  const HeldNodes held = FixedWhere(solid, [](const Vector3d& p) { return p.z() < 1e-9; });
  FemGreenModel model(solid, held, 1, Sphere3d::kNu, {.contact = ContactLaw::kFrictionless});
  RoundIndenter tool(TouchableNodes(SurfaceOf(solid)), Sphere3d::kRadius,
                     ContactLaw::kFrictionless);
  Solution solution;
  for (const double depth : {0.007, 0.012}) {
    const ContactResponse response = tool.Press(Sphere3d::At(depth), &model, &solution);
    ASSERT_NE(response.validity, Validity::kFailed) << model.failure();
    EXPECT_NEAR(-response.force_O.z() / Sphere3d::Force(depth), 1, 0.15) << depth;
  }
}

// Reference: hexahedra of another program, 0.233 N. Only four midpoints of edges touch, and the
// force is a quarter too low.
TEST(RoundIndenter3d, AFewPlacesAreNoContact) {
  const SolidMesh solid = MeshBox({0.06, 0.06, 0.03}, {6, 6, 3});
  const HeldNodes held = FixedWhere(solid, [](const Vector3d& p) { return p.z() < 1e-9; });
  FemGreenModel model(
      solid, held, 30e3, 0.3,
      {.element = FemOptions::Element::kTet10, .contact = ContactLaw::kFrictionless});
  RoundIndenter tool(TouchableMiddles(SurfaceOf(solid)), 0.02, ContactLaw::kFrictionless);
  Solution solution;
  for (const auto& [depth, few] : {std::pair{0.001, true}, std::pair{0.002, false}}) {
    const ContactResponse response =
        tool.Press({{0.03, 0.03, 0.03}, {0, 0, 1}, {0, 0, -depth}}, &model, &solution);
    EXPECT_EQ(response.validity == Validity::kExtrapolated, few) << solution.contacts().size();
    if (!few) {
      EXPECT_NEAR(-response.force_O.z() / 0.6634, 1, 0.1);
    }
  }
}

}  // namespace
}  // namespace palpate
