// Stresses of laws under known loads, against closed forms.
#include "slave/identify/material_test.h"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/slave/identify/synthetic.h"

namespace palpate::identify {
namespace {

const HyperLaw kMooney{.name = "mooney", .terms = {{700, 2}, {300, -2}}};

// Rivlin 1948, with 2 C1 = 700 and 2 C2 = 300 Pa.
TEST(MaterialTest, MooneyFollowsRivlin) {
  for (const double l : {0.6, 1.4, 2.5}) {
    const auto nominal = [&](TestKind kind) {
      MaterialTest test{.kind = kind, .components = {{0, 0}}};
      test.rows = {{.abscissa = l, .measured = {0}}};
      return Predict(kMooney, test)[0];
    };
    EXPECT_NEAR(nominal(TestKind::kUniaxial), (l - 1 / (l * l)) * (700 + 300 / l), 1e-9);
    EXPECT_NEAR(nominal(TestKind::kPlanar), (l - 1 / (l * l * l)) * 1000, 1e-9);
    EXPECT_NEAR(nominal(TestKind::kEquibiaxial), (l - std::pow(l, -5)) * (700 + 300 * l * l), 1e-9);
  }
  const MaterialTest shear = CurveOf(kMooney, TestKind::kShear, 1.2, 3);
  for (const TestRow& row : shear.rows) {
    EXPECT_NEAR(row.measured[0], 1000 * row.abscissa, 1e-9);
  }
}

// True stress is nominal stress times the stretch along it.
TEST(MaterialTest, TrueStressIsNominalByStretch) {
  MaterialTest test = CurveOf(kMooney, TestKind::kUniaxial, 1.5, 1);
  const double nominal = test.rows[0].measured[0];
  test.cauchy = true;
  EXPECT_NEAR(Predict(kMooney, test)[0], 1.5 * nominal, 1e-9);
}

TEST(MaterialTest, DataThatNoIsotropicLawFitsAreReported) {
  MaterialTest test{.kind = TestKind::kBiaxial, .name = "BT", .components = {{0, 0}, {1, 1}}};
  for (const double l : {1.1, 1.2, 1.3, 1.4}) {
    test.rows.push_back({.abscissa = l, .across = l, .measured = {1000 * l, 1000 * l}});
  }
  EXPECT_EQ(AgainstIsotropy(test), "");
  test.rows[2].measured[1] = 700;
  EXPECT_NE(AgainstIsotropy(test).find("BT: the stretch is 1.3 in both directions"),
            std::string::npos);
}

// Yeoh's law with a negative second modulus softens until it becomes unstable; terms with positive
// moduli never do.
TEST(Stability, IsSeenAndNamed) {
  const HyperLaw stable{.name = "ogden", .terms = {{500, 12}, {100, -20}}};
  EXPECT_EQ(FirstInstability(stable, 0.3, 4), "");
  const HyperLaw unstable{.name = "yeoh", .yeoh = {500, -100, 0}};
  EXPECT_NE(FirstInstability(unstable, 0.5, 4).find("unstable from a stretch of"),
            std::string::npos);
  EXPECT_LT(MinStability(unstable, {3, 1 / std::sqrt(3.0), 1 / std::sqrt(3.0)}), 0);
}

}  // namespace
}  // namespace palpate::identify
