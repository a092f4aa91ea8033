// The central von Karman press: the tables, the membrane limit, and the differential equations.
#include "slave/mechanics/plate/round_press.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/green.h"
#include "tests/reference/reference_file.h"

namespace palpate::plate {
namespace {

using reference::CaseOf;
using reference::json;

// Reference: c membrane_limit: the table's own convergence is 1e-6; Schwerin's pi / 3 beyond it,
// approached like a power of t / w.
TEST(RoundPress, ApproachesSchwerinsMembrane) {
  PALPATE_REFERENCE_OR_SKIP(file, "c_plate.json");
  const json c = CaseOf(file, "membrane_limit");
  RoundPress press(1.0 / 3, 0);
  for (const auto& [w_text, ratio] : c.at("expected").at("F_bar_over_w3").items()) {
    const double w = std::stod(w_text);
    ASSERT_TRUE(press.SolveDeflection(w));
    EXPECT_NEAR(press.force() / (w * w * w) / ratio.get<double>(), 1, 1e-5) << w;
  }
  ASSERT_TRUE(press.SolveDeflection(1000));
  EXPECT_NEAR(press.force() / 1e9 / (std::numbers::pi / 3), 1, 4e-3);
}

// Reference: the closed form at small deflection, at the centre.
TEST(RoundPress, IsTheLinearPlateWhereItBendsOnly) {
  for (const double nu : {-0.9, 0.0, 0.3, 0.5}) {
    for (const double R : {0.0, 1e-3, 0.05, 0.3, 0.7, 0.95, 1.0}) {
      RoundPress press(nu, R);
      const double F = 1e-6, D = 1 / (12 * (1 - nu * nu));
      ASSERT_TRUE(press.SolveForce(F));
      const double w = F / D * Deflection(Disc{{0, 0}, R}, {0, 0});
      EXPECT_NEAR(press.deflection() / w, 1, 1e-8) << nu << " " << R;
    }
  }
}

// Reference: a stretched membrane under a disc of load deflects by F / (2 pi N) (ln(1 / R) + 1 / 2)
// at the centre; at N0 = 1e6 D the bending layer at the edge reduces this by sqrt(D / N) = 1e-3.
TEST(RoundPress, AStrongPrestressMakesAMembrane) {
  const double nu = 0.3, D = 1 / (12 * (1 - nu * nu)), N = 1e6 * D, R = 0.2;
  RoundPress press(nu, R, N);
  ASSERT_TRUE(press.SolveForce(1));
  const double w = (std::log(1 / R) + 0.5) / (2 * std::numbers::pi * N);
  EXPECT_NEAR(press.deflection() / w, 1, 1.5e-3);
  EXPECT_LT(press.deflection(), w);
}

// Reference: the work of the force is the energy: F = dU/dw, so the tangent is dF/dw. Central
// differences with a step of 1e-4 have an error of 1e-8.
TEST(RoundPress, TheStiffnessIsTheSlopeOfTheForce) {
  for (const double w : {0.1, 1.0, 5.0, 30.0}) {
    RoundPress press(0.45, 0.05);
    const double h = 1e-4 * w;
    ASSERT_TRUE(press.SolveDeflection(w + h));
    const double above = press.force();
    ASSERT_TRUE(press.SolveDeflection(w - h));
    const double below = press.force();
    ASSERT_TRUE(press.SolveDeflection(w));
    EXPECT_NEAR(press.stiffness() * 2 * h / (above - below), 1, 1e-6) << w;
  }
}

TEST(RoundPress, ConvergesFromAnyState) {
  RoundPress press(0.45, 0);
  ASSERT_TRUE(press.SolveDeflection(7));
  const double F = press.force();
  ASSERT_TRUE(press.SolveDeflection(-7));
  EXPECT_NEAR(press.force() / F, -1, 1e-9);
  ASSERT_TRUE(press.SolveDeflection(0));
  EXPECT_NEAR(press.force() / F, 0, 1e-12);
  ASSERT_TRUE(press.SolveDeflection(500));
  ASSERT_TRUE(press.SolveDeflection(1e-9));
  ASSERT_TRUE(press.SolveDeflection(7));
  EXPECT_NEAR(press.force() / F, 1, 1e-9);
  EXPECT_FALSE(press.SolveDeflection(std::nan("")));
}

}  // namespace
}  // namespace palpate::plate
