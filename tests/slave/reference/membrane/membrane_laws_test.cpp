// Compares the simulator's law (the truth) with the estimator's law, and determines the part of the
// difference that remains if the force is found from the dots.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/fit/load_fit.h"
#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_law.h"
#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/vision/dots/dot_layout.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/plate/presses.h"

namespace palpate::simulation {
namespace {

using Eigen::Vector2d;

constexpr double kLawRadius = 0.039, kLawYoung = 27.2e6, kLawPoisson = 0.45;

struct Laws {
  double depth = 0, truth = 0;  // [m], [N]
  double by_depth = 0;          // von Karman's force at the truth's depth, over the truth's
  double by_dots = 0;           // force found from the true dots
  double misplaced = 0;         // of the load found [m]
  double stated = 0;            // by_depth - 1 as stated by plate_law.h
  bool flagged = false;         // von Karman's force at the truth's depth
};

// The dots of paper C's membrane, without noise: displacements along z of its inner face, at the
// places where the dots rest.
std::vector<Laws> CompareLaws(double thickness, double width, const Vector2d& p_O, double step) {
  PressedMembrane truth({kLawRadius, thickness}, {kLawYoung, kLawPoisson}, width, p_O);
  PlateLargeModel plate({.radius = kLawRadius,
                         .thickness = thickness,
                         .young_modulus = kLawYoung,
                         .poisson_ratio = kLawPoisson,
                         .order = 20});
  LoadFitter fitter(plate, {width});
  const auto dots = DotPlaces(PointTracking{});
  const std::vector<double> sigma(dots.size(), 50e-6);
  std::vector<double> displacement(dots.size());
  std::vector<Laws> all;
  for (double depth = step; depth < 5e-3 + 1e-9; depth += step) {
    if (!truth.Deepen(depth)) ADD_FAILURE() << "no equilibrium at " << depth;
    for (std::size_t i = 0; i < dots.size(); ++i) {
      displacement[i] = DisplacementAt(truth.press(), dots[i], depth).z();
    }
    const auto response = contacts::Answer(plate, plates::Moved(p_O, depth, width));
    const LoadFit fit = fitter.Fit(dots, displacement, sigma);
    const double force = truth.press().depth_steps.back()->force;
    const double stated =
        plate::ExcessAtDepth({p_O.norm() / kLawRadius, depth / kLawRadius, thickness / kLawRadius});
    all.push_back({depth, -force, response.force_O.z() / force, fit.force / force,
                   (fit.p_O - p_O).norm(), stated, response.validity != Validity::kValid});
  }
  return all;
}

// Reference: the solid itself. The threshold of the flag is 10 %, and the stated error is accurate
// to 3 %.
void ExpectStated(const std::vector<Laws>& all) {
  for (const Laws& laws : all) {
    const double excess = laws.by_depth - 1;
    if (laws.stated < 0.15) {
      EXPECT_NEAR(excess, laws.stated, 0.03) << laws.depth;
    }
    if (excess > 0.125) {
      EXPECT_TRUE(laws.flagged) << laws.depth;
    }
    if (excess < 0.075) {
      EXPECT_FALSE(laws.flagged) << laws.depth;
    }
  }
}

Vector2d Beside(double radii) {
  return radii * kLawRadius * Vector2d(std::cos(0.4), std::sin(0.4));
}

// The allowed error is 5 % of the force, or 1 % of the force at 5 mm. At every half millimetre, at
// the centre and beside it, the force found with von Karman's plate from the dots of the
// neo-Hookean membrane must be within half of this. Measured: -1.8 to 2.6 %.
TEST(MembraneLaws, DotsDetermineTheForceOfTheOtherLaw) {
  for (const double radii : {0.0, 0.3, 0.5, 0.7}) {
    const auto all = CompareLaws(1e-3, 0.004, Beside(radii), 0.5e-3);
    ExpectStated(all);
    for (const Laws& laws : all) {
      const double allowed = std::max(0.05, 0.01 * all.back().truth / laws.truth);
      EXPECT_LT(std::abs(laws.by_dots - 1), 0.6 * allowed) << radii << " " << laws.depth;
      EXPECT_LT(laws.misplaced, 0.5e-3) << radii << " " << laws.depth;
    }
  }
}

// A rigid face off the centre touches only with its outer arc, so the uniform load is found up to 2
// mm farther out (5 mm for the wide tool). Measured: -0.6 to 3.4 % of the force, misplaced by 0.2
// mm.
TEST(MembraneLaws, DotsDetermineForceAndPlaceOfARigidTool) {
  PlateLargeModel plate({.radius = kLawRadius,
                         .thickness = 1e-3,
                         .young_modulus = kLawYoung,
                         .poisson_ratio = kLawPoisson,
                         .order = 20});
  const auto dots = DotPlaces(PointTracking{});
  const std::vector<double> sigma(dots.size(), 50e-6);
  std::vector<double> displacement(dots.size());
  for (const double width : {0.004, 0.012}) {
    for (const double radii : {0.0, 0.5}) {
      const Vector2d p_O = Beside(radii);
      PressedMembrane truth({kLawRadius, 1e-3}, {kLawYoung, kLawPoisson}, width, p_O, {}, 0,
                            ToolFace::kRigid);
      LoadFitter fitter(plate, {width, true});
      for (const double depth : {1e-3, 2e-3, 4e-3}) {
        ASSERT_TRUE(truth.Deepen(depth));
        for (std::size_t i = 0; i < dots.size(); ++i) {
          displacement[i] = DisplacementAt(truth.press(), dots[i], depth).z();
        }
        const LoadFit fit = fitter.Fit(dots, displacement, sigma);
        EXPECT_NEAR(fit.force / truth.press().depth_steps.back()->force, 1, 0.03) << radii << depth;
        EXPECT_LT((fit.p_O - p_O).norm(), 0.3e-3) << radii << ' ' << depth;
        EXPECT_NEAR(-fitter.solution().responses().front().displacement_O.z() / depth, 1, 0.05);
      }
    }
  }
}

// Reference: neo-Hookean solid elements of another program (set h, tool of 10 mm): von Karman's
// force at 5 mm is high by 4 to 10 % for 0.5 to 2 mm.
TEST(MembraneLaws, DifferByFourToTenPerCentAtOneDepth) {
  double last = 0.04;
  for (const double thickness : {0.5e-3, 1e-3, 2e-3}) {
    const auto all = CompareLaws(thickness, 0.010, {0, 0}, 1e-3);
    const double high = all.back().by_depth - 1;
    EXPECT_GT(high, last - 0.005) << thickness;
    EXPECT_LT(high, 0.10) << thickness;
    EXPECT_LT(std::abs(all.back().by_dots - 1), 0.05) << thickness;
    last = high;
  }
}

// Keeps the measured values for other thicknesses off the centre.
TEST(MembraneLaws, OtherThicknessesStayWithinFivePerCent) {
  for (const double thickness : {0.5e-3, 2e-3}) {
    for (const double radii : {thickness < 1e-3 ? 0.3 : 0.0, 0.5}) {
      const auto all = CompareLaws(thickness, 0.004, Beside(radii), 1e-3);
      ExpectStated(all);
      for (const Laws& laws : all) {
        EXPECT_LT(std::abs(laws.by_dots - 1), 0.05) << thickness << " " << radii;
      }
    }
  }
}

}  // namespace
}  // namespace palpate::simulation
