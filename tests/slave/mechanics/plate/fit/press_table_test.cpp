#include "slave/mechanics/plate/fit/press_table.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

constexpr double kTableRadius = 0.039, kTableModulus = 27.2e6, kTableNu = 0.45, kTableWidth = 0.004;

// Reference: the model, asked at places and depths between the table's. Near the centre, where the
// model changes from modes to its exact central solution, they differ by 0.7 %.
TEST(PressTable, IsTheModelBetweenItsEntries) {
  for (const double thickness : {0.0002, 0.001, 0.0039}) {
    PlateLargeModel plate({kTableRadius, thickness, kTableModulus, kTableNu});
    const PressTable table(plate, {kTableWidth});
    for (const double r : {0.0032, 0.0071, 0.0117, 0.0195, 0.0292}) {
      for (const double depth : {1e-5, 1.3e-4, 9e-4, 2.1e-3, 4.9e-3}) {
        const Contact contact{
            .p_O = {r, 0, 0}, .width = kTableWidth, .prescribed_O = {0, 0, -depth}};
        ContactResponse response;
        plate.Respond(std::span(&contact, 1), std::span(&response, 1));
        const PressTable::Press press = table.At(r, depth);
        EXPECT_NEAR(press.force / -response.force_O.z(), 1, 5e-3)
            << thickness << " " << r << " " << depth;
        EXPECT_NEAR(press.stiffness / response.stiffness_O(2, 2), 1, 2e-2)
            << thickness << " " << r << " " << depth;
      }
    }
  }
}

// Reference: the closed form, F = 4 pi E t^3 a^2 w / (3 (1 - nu^2) (a^2 - p^2)^2), paper C, eq.
// (1).
TEST(PressTable, ForSmallDeflectionsItIsEquationOneOfPaperC) {
  const double t = 0.001;
  PlateModel plate({kTableRadius, t, kTableModulus, kTableNu});
  const PressTable table(plate, {0});
  for (const double p : {0.0, 0.01, 0.0233, 0.03}) {
    const double inside = kTableRadius * kTableRadius - p * p;
    const double k = 4 * std::numbers::pi * kTableModulus * t * t * t * kTableRadius *
                     kTableRadius / (3 * (1 - kTableNu * kTableNu) * inside * inside);
    const PressTable::Press press = table.At(p, 2e-4);
    EXPECT_NEAR(press.force / (k * 2e-4), 1, 1e-6) << p;
    EXPECT_NEAR(press.stiffness / k, 1, 1e-6) << p;
    EXPECT_TRUE(press.valid);
    EXPECT_FALSE(table.At(p, 1.5e-3).valid);  // beyond half the thickness
  }
}

// The force is the integral of the stiffness, so that pressing in steps cannot deliver energy.
TEST(PressTable, StiffnessIsTheForcesSlope) {
  PlateLargeModel plate({kTableRadius, 0.001, kTableModulus, kTableNu});
  const PressTable table(plate, {kTableWidth});
  for (const double r : {0.0, 0.0103, 0.034, 0.0389}) {
    for (double depth = 1e-4; depth < 0.014; depth += 3.7e-4) {
      const double h = 1e-8;
      const double slope = (table.At(r, depth + h).force - table.At(r, depth - h).force) / (2 * h);
      EXPECT_NEAR(table.At(r, depth).stiffness / slope, 1, 1e-4) << r << " " << depth;
    }
  }
}

TEST(PressTable, AnswersNonsenseWithoutForce) {
  PlateLargeModel plate({kTableRadius, 0.001, kTableModulus, kTableNu});
  const PressTable table(plate, {kTableWidth});
  const long before = AllocationCount();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), inf, -inf}) {
    EXPECT_EQ(table.At(bad, 1e-3).force, 0);
    EXPECT_EQ(table.At(0, bad).force, 0);
    EXPECT_FALSE(table.At(0, bad).valid);
  }
  EXPECT_EQ(table.At(0.01, -1).force, 0);
  EXPECT_GT(table.At(0.01, -1).stiffness, 0);
  EXPECT_TRUE(std::isfinite(table.At(1e300, 1e300).force));
  EXPECT_FALSE(table.At(0, 1).valid);
  EXPECT_EQ(table.At(1, 1e-3).force, table.At(table.largest_radius(), 1e-3).force);
  EXPECT_EQ(AllocationCount(), before);
}

}  // namespace
}  // namespace palpate
