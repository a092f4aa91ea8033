// Plane elasticity against a_elastostatics2d.json: exact solutions where there are some, and the
// numbers of another constant-element solver where both must agree.
#include <cmath>
#include <string>

#include <Eigen/Dense>

#include "tests/reference/reference_file.h"
#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using reference::json;

// Reference: Lame's solution up to nu = 0.5, by the radial displacements of the midpoints. Where
// the plain equations are used, they give the discrete numbers of the reference (5 %: near nu =
// 0.49 the pressure in the hole becomes inaccurate). Beyond, the equation for that pressure keeps
// the error at 0.1 %, which is the missing area of a polygon with 60 sides.
TEST(Elastostatics2d, ARingIsRightUpToNuOneHalf) {
  PALPATE_REFERENCE_OR_SKIP(file, "a_elastostatics2d.json");
  const json c = reference::CaseOf(file, "lame_near_incompressible");
  int beyond = 0;
  for (const auto& row : c.at("expected")) {
    const double nu = row.at("nu");
    const Plane plane = reference::PlaneOf(row);
    const ReferenceProblem problem = bodies::Free(bodies::Ring(1, 2, 60), nu, plane);
    Bem2dModel model(problem, {.young_modulus = 1, .thickness = 1});
    const auto loads = bodies::PressureOnLastLoop(problem.mesh, 1, 1);
    Solution solution;
    ASSERT_NE(bodies::Respond(model, loads, &solution).front().validity, Validity::kFailed);
    const auto displacement = model.Boundary(solution).displacement;
    const auto radial = [&](std::size_t i) {
      return displacement[i].dot(problem.mesh.elements[i].midpoint().normalized());
    };
    const double u_a = radial(60), u_b = radial(0), exact = row.at("u_a_E_over_p_a");
    const bool plain = plane == Plane::kStress || nu <= GreensFunctions::kMaxNuWithoutHolePressures;
    EXPECT_NEAR(u_a / exact, 1, plain ? 0.05 : 0.001) << nu;
    if (!plain) {
      ++beyond;
      continue;
    }
    const json& own = row.at("own_constant_bem_60_plus_60");
    EXPECT_NEAR(u_a / own.at("u_a").get<double>(), 1, 1e-6) << nu;
    EXPECT_NEAR(u_b / own.at("u_b").get<double>(), 1, 1e-6) << nu;
  }
  EXPECT_GE(beyond, 3);
}

// --- tests of the matrices

// Reference: the 2-norm condition of the mixed problem, 60 elements on a square of side 0.5; the
// library estimates it in the 1-norm, for which 1/n <= cond_2 / cond_1 <= n; the test distinguishes
// well-posed (1e2) from ill-conditioned (1e5 and more).
TEST(Elastostatics2d, TheMixedProblemStaysWellConditionedAtNuOneHalf) {
  PALPATE_REFERENCE_OR_SKIP(file, "a_elastostatics2d.json");
  const json c = reference::CaseOf(file, "bem_conditioning_vs_nu");
  for (const auto& row : c.at("expected")) {
    const double nu = row.at("nu");
    ReferenceProblem problem = bodies::Block(60, 0.5, nu);
    problem.mesh.length_unit = 1;
    const double condition = GreensFunctions(problem).condition();
    const double expected = row.at("cond_mixed_fixed_side");
    EXPECT_GT(condition, expected / 10);
    EXPECT_LT(condition, expected * 10);
  }
}

// Reference: at the critical radius the kernel matrix of the all-displacement problem is singular.
// The length units that the meshes choose are far from it.
TEST(Elastostatics2d, TheDegenerateScaleIsWhereItShouldBeAndNeverUsed) {
  PALPATE_REFERENCE_OR_SKIP(file, "a_elastostatics2d.json");
  const json c = reference::CaseOf(file, "degenerate_scale_circle");
  for (const auto& row : c.at("expected")) {
    const double nu = row.at("nu");
    if (nu > GreensFunctions::kMaxNuAllHeld) continue;
    const auto condition_at = [&](double radius_in_units) {
      ReferenceProblem problem = bodies::Free(MeshDisc(1, 120), nu, Plane::kStrain);
      problem.mesh.length_unit = 1 / radius_in_units;
      for (auto& held : problem.held) held = {true, true};
      return GreensFunctions(problem).condition();
    };
    const double critical = row.at("critical_radius_own_bem_120");
    EXPECT_GT(condition_at(critical), 1e5 * condition_at(1));
    EXPECT_LT(condition_at(1), 1e4);
  }
}

// Reference: the flexibility block and the stiffness of the element at the centre of the block's
// top.
TEST(Elastostatics2d, TheBlocksFlexibilityIsThatOfTheReference) {
  PALPATE_REFERENCE_OR_SKIP(file, "a_elastostatics2d.json");
  const json c = reference::CaseOf(file, "cma_block60");
  const GreensFunctions greens(bodies::Block(60, 1, c.at("params").at("nu"), Plane::kStress));
  const Eigen::Map<const Matrix2d> flexibility(greens.block(37, 37));
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      EXPECT_NEAR(flexibility(i, j),
                  c.at("expected").at("flexibility_block_E_SS").at(i).at(j).get<double>(), 1e-9);
    }
  }
  EXPECT_NEAR(greens.lengths()[37] / flexibility(1, 1), c.at("expected").at("k_bar").get<double>(),
              1e-9);
}

}  // namespace
}  // namespace palpate
