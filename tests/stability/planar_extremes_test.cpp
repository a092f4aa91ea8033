// The planar model at the ends of its range: sizes from 1 nm to 1 km, moduli from 1 Pa to 1 TPa, nu
// up to 0.5, slivers, hundreds of contacts. Right, flagged or refused; never NaN.
#include <tuple>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

struct Answer {
  double k_bar = 0;       // force / (E depth thickness)
  double compliance = 0;  // displacement by a load, times E thickness / load
  double stiffness = 0;   // by the model's own stiffness, over E thickness
};

Answer Press(double side, double E, double nu, Plane plane) {
  const double thickness = 0.1 * side;
  Bem2dModel model(bodies::Block(60, side, nu, plane),
                   {.young_modulus = E, .thickness = thickness});
  const double depth = 1e-3 * side;
  const double force = 1e-4 * E * side * thickness;
  const auto responses =
      bodies::Respond(model, {bodies::Move(37, {0, -depth}), bodies::Load(20, {-force, 0})});
  for (const auto& response : responses) EXPECT_EQ(response.validity, Validity::kValid);
  return {-responses[0].force_O.y() / (E * depth * thickness),
          -responses[1].displacement_O.x() * E * thickness / force,
          responses[0].stiffness_O(1, 1) / (E * thickness)};
}

class PlanarExtremes
    : public testing::TestWithParam<std::tuple<double, double, std::pair<Plane, double>>> {};

// Reference: dimensional analysis; the same nondimensional numbers as at 1 m and 1 Pa, to 1e-9
// (rounding of the mesh's coordinates times the condition is 1e-13).
TEST_P(PlanarExtremes, TheNondimensionalAnswerDoesNotDependOnScaleOrStiffness) {
  const auto [side, E, material] = GetParam();
  const auto [plane, nu] = material;
  const Answer reference = Press(1, 1, nu, plane);
  const Answer answer = Press(side, E, nu, plane);
  EXPECT_GT(reference.k_bar, 0.1);
  EXPECT_NEAR(answer.k_bar / reference.k_bar, 1, 1e-9);
  EXPECT_NEAR(answer.compliance / reference.compliance, 1, 1e-9);
  EXPECT_NEAR(answer.stiffness / reference.stiffness, 1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(SizeModulusMaterial, PlanarExtremes,
                         testing::Combine(testing::Values(1e-9, 1e-6, 1e-3, 1.0, 1e3),
                                          testing::Values(1.0, 1e3, 1e6, 1e9, 1e12),
                                          testing::Values(std::pair{Plane::kStress, 0.5},
                                                          std::pair{Plane::kStrain, 0.45},
                                                          std::pair{Plane::kStrain, 0.4999},
                                                          std::pair{Plane::kStrain, 0.5},
                                                          std::pair{Plane::kStress, -0.9})));

// Reference: continuity; nothing happens between nearly and fully incompressible.
TEST(PlanarStability, NuOneHalfIsTheLimitOfNuBelow) {
  const Answer below = Press(0.088, 127e3, 0.5 - 1e-9, Plane::kStrain);
  const Answer half = Press(0.088, 127e3, 0.5, Plane::kStrain);
  EXPECT_NEAR(below.k_bar / half.k_bar, 1, 1e-7);
}

// Reference: a strip a hundred thousand times longer than thick, pulled, stretches by F L / (E A);
// what constant elements make of it is refused, flagged or a finite number, never NaN.
TEST(PlanarStability, SliversAreAnsweredOrRefused) {
  for (const double height : {1e-2, 1e-3, 1e-5}) {
    try {
      ReferenceProblem problem{MeshRectangle(1, height, 200), {}, 0.3, Plane::kStress};
      for (const auto& e : problem.mesh.elements) {
        const bool left = e.normal().x() < -0.5;
        problem.held.push_back({left, left});
      }
      Bem2dModel model(problem, {.young_modulus = 1, .thickness = 1});
      Contact pull = bodies::Load(-1, {1e-4 * height, 0});
      pull.p_O = {1, 0.5 * height, 0};
      const auto response = bodies::Respond(model, {pull}).front();
      EXPECT_TRUE(response.displacement_O.allFinite());
      EXPECT_TRUE(response.stiffness_O.allFinite());
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("expected"), std::string::npos);
    }
  }
}

// Reference: linearity; the largest and smallest displacements that are no fault.
TEST(PlanarStability, ForcesStayProportionalFromTinyToHugeDisplacements) {
  Bem2dModel model(bodies::Block(60), {.young_modulus = 1e6, .thickness = 1});
  const double unit = bodies::Respond(model, {bodies::Move(37, {0, -1})}).front().force_O.y();
  for (const double depth : {1e-300, 1e-30, 1e-12, 1e-3, 1e3, 9e5}) {
    const auto response = bodies::Respond(model, {bodies::Move(37, {0, -depth})}).front();
    ASSERT_NE(response.validity, Validity::kFailed) << depth;
    EXPECT_NEAR(response.force_O.y() / (unit * depth), 1, 1e-12) << depth;
  }
  for (const double depth : {2e6, 1e300}) {
    const auto response = bodies::Respond(model, {bodies::Move(37, {0, -depth})}).front();
    EXPECT_EQ(response.validity, Validity::kFailed);
  }
}

// Reference: all that can move is moved together, by five hundred contacts and by the one patch
// that they make up: the same force, and every contact's own answer as it is in the patch.
TEST(PlanarStability, FiveHundredContactsEqualThePatchTheyMakeUp) {
  Bem2dModel model(bodies::Block(680), {.young_modulus = 1e6, .thickness = 1});
  const auto& elements = model.greens_functions().problem().mesh.elements;
  const Vector2d moved(1e-3, -1e-3);
  Contact patch = bodies::Move(425, moved);  // in the middle of the top
  patch.p_O.head<2>() = elements[425].a;
  patch.width = 3;  // three sides
  Solution solution;
  const auto together = bodies::Respond(model, {patch}, &solution).front();
  ASSERT_EQ(together.validity, Validity::kValid);
  const BoundaryState boundary = model.Boundary(solution);

  std::vector<Contact> contacts;
  for (int i = 170; i < 680; ++i) contacts.push_back(bodies::Move(i, moved));
  const auto responses = bodies::Respond(model, contacts);
  Vector2d sum = Vector2d::Zero();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ASSERT_EQ(responses[k].validity, Validity::kValid);
    const Vector2d force = responses[k].force_O.head<2>();
    const std::size_t i = 170 + k;
    EXPECT_LT((force - elements[i].length() * boundary.traction[i]).norm(),
              1e-9 * together.force_O.norm())
        << "element " << i;
    sum += force;
  }
  EXPECT_LT((together.force_O.head<2>() - sum).norm(), 1e-9 * sum.norm());
}

}  // namespace
}  // namespace palpate
