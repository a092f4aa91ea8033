#include "slave/reference/planar/patch_solution.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/slave/reference/planar/planar_scenes.h"
#include "tests/support/references.h"

namespace palpate::simulation {
namespace {

// Stiffness of the tool against a unit press along the inward normal, and along the tangent for the
// same press.
Eigen::Vector2d PressStiffness(const PatchSolution& solution, const Eigen::Vector2d& normal) {
  const Eigen::Vector2d force = solution.stiffness * -normal;
  return {-force.dot(normal), force.dot(Eigen::Vector2d(-normal.y(), normal.x()))};
}

PatchSolution SolveBlock(double nu, Plane plane, int s_mm, const Fineness& f = {}) {
  const TrueBody body(BlockScene());
  return SolvePatch(body, nu, plane, body.PlaceAt(0, s_mm * 1e-3), 0.088 / 15, f);
}

// Reference: continuum values of b_block_embryo.json (p-version finite elements, good to 2e-6 on
// the block and 3e-5 on the disc), bonded and sliding, several places and a disc, nu from 0.3 to
// 0.5. Tolerance: the accuracy the site promises, 1e-3.
TEST(PatchSolution, AgreesWithTheContinuumWithinOnePerMille) {
  PALPATE_REFERENCE_OR_SKIP(reference, "b_block_embryo.json");
  int compared = 0;
  for (const auto& c : reference["cases"]) {
    const std::string id = c["id"];
    const bool slides = id.ends_with("_frictionless");
    if (!slides && id.find("_bonded") == std::string::npos) continue;
    if (!c["expected"].contains("k_bar")) continue;
    const auto& p = c["params"];
    Scene scene = id.starts_with("disc") ? EmbryoScene() : BlockScene();
    scene.object.material.poisson_ratio = p["poisson_ratio"];
    const Plane plane = p["plane"] == "stress" ? Plane::kStress : Plane::kStrain;
    BoundaryPlace place;
    double width = 0, tilt = 0;
    if (id.starts_with("disc")) {
      const double R = p["radius_m"];
      scene.object.fixed = {{FixedArc{p["hold_arc_centre_rad"], p["hold_arc_half_angle_rad"]}}};
      width = 2 * R * p["patch_half_angle_rad"].get<double>();
      place = TrueBody(scene).Nearest({R, 0});
    } else {
      const double lo = p["patch_lo_m"], hi = p["patch_hi_m"], side = p["width_m"];
      width = hi - lo;
      const double middle = 0.5 * (lo + hi);
      const bool top = p["indented_side"] == "top";
      place = TrueBody(scene).Nearest(top ? Eigen::Vector2d(middle, side)
                                          : Eigen::Vector2d(side, middle));
      if (c["expected"].contains("tangential_over_normal_force")) {
        tilt = c["expected"]["tangential_over_normal_force"];
      }
    }
    const TrueBody body(scene);
    const double nu = scene.object.material.poisson_ratio;
    Eigen::Vector2d k(0, 0);
    if (slides) {
      k.x() = SlidingStiffness(body, nu, plane, place, width, -place.normal_O);
    } else {
      k = PressStiffness(SolvePatch(body, nu, plane, place, width), place.normal_O);
    }
    const double error = k.x() / c["expected"]["k_bar"].get<double>() - 1;
    ++compared;
    EXPECT_LT(std::abs(error), 1e-3) << id;
    if (!slides && !id.starts_with("disc")) {
      EXPECT_NEAR(std::abs(k.y() / k.x()), std::abs(tilt), 1e-3) << id;
    }
  }
  EXPECT_GE(compared, 40);
}

// Reference: theory of graded quadratic elements: the energy's error falls with the square of the
// number of unknowns, as long as the elements at the singular ends shrink along. The finest mesh
// is the limit. The order is 2; 1.4 is requested, since each mesh is a new one and the reference is
// itself a mesh.
TEST(PatchSolution, ConvergesAtSecondOrderInTheNumberOfUnknowns) {
  const auto with = [](double factor) {
    Fineness f;
    f.largest *= factor;
    f.growth *= factor;
    f.at_support_end *= factor * factor * factor * factor;
    f.at_patch_end *= factor * factor * factor * factor;
    const PatchSolution s = SolveBlock(0.49, Plane::kStress, 88 + 88 + 44, f);
    return std::pair(2.0 * static_cast<double>(s.mesh.nodes.size()), s.stiffness(1, 1));
  };
  const double limit = with(0.3).second;
  double unknowns_before = 0, error_before = 0, order = 0;
  for (const double factor : {2.0, 1.4, 1.0, 0.7}) {
    const auto [unknowns, k] = with(factor);
    const double error = k / limit - 1;
    if (error_before > 0) {
      order = std::log(error_before / error) / std::log(unknowns / unknowns_before);
    }
    EXPECT_GT(error, 0) << "a displacement method is too stiff";
    unknowns_before = unknowns;
    error_before = error;
  }
  EXPECT_GT(order, 1.4);
}

// Reference: reciprocity (Betti) and positive energy f . d / 2. K is not made symmetric by the
// code: its two off-diagonal terms come from two solutions. Tolerance: rounding over a mesh graded
// 1 : 1e4.
TEST(PatchSolution, StiffnessIsSymmetricAndPositiveDefinite) {
  const TrueBody body(BlockScene());
  for (const auto& [nu, plane] : {std::pair(0.3, Plane::kStress), std::pair(0.5, Plane::kStrain)}) {
    for (const double s : {0.100, 0.196, 0.230}) {
      const Eigen::Matrix2d K = SolvePatch(body, nu, plane, body.PlaceAt(0, s), 0.004).stiffness;
      EXPECT_NEAR(K(0, 1), K(1, 0), 1e-10 * K.norm());
      EXPECT_GT(std::abs(K(0, 1)), 1e-3 * K.norm()) << "off the middle x and y are coupled";
      EXPECT_GT(K(0, 0), 0);
      EXPECT_GT(K.determinant(), 0);
    }
  }
}

TEST(TrueBody, APatchEndsAtASharpCornerAndGoesRoundAGentleOne) {
  const TrueBody block(BlockScene());
  const auto [from, to] = block.Patch(block.Nearest({0.087, 0.088}), 0.004);
  EXPECT_NEAR(from, 0.176, 1e-12);  // the upper right corner
  EXPECT_NEAR(to, 0.176 + 0.001 + 0.002, 1e-12);
  const TrueBody disc(EmbryoScene());
  const auto place = disc.Nearest({0.6e-3, 0});
  const auto [a, b] = disc.Patch(place, 0.2e-3);
  EXPECT_NEAR(b - a, 0.2e-3, 1e-15);
  EXPECT_NEAR(0.5 * (a + b), place.s, 1e-15);
}

}  // namespace
}  // namespace palpate::simulation
