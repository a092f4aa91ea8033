// Fits find a law again from curves that were computed with it.
#include "slave/identify/law_fit.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/identify/chord_modulus.h"
#include "tests/slave/identify/synthetic.h"

namespace palpate::identify {
namespace {

using testing::HasSubstr;

std::vector<MaterialTest> ThreeTests(const HyperLaw& law, double noise = 0) {
  return {CurveOf(law, TestKind::kUniaxial, 2.5, 30, noise, 1),
          CurveOf(law, TestKind::kEquibiaxial, 1.8, 30, noise, 2),
          CurveOf(law, TestKind::kPlanar, 2.2, 30, noise, 3)};
}

// Without noise the fit returns the constants within the tolerance of the search.
TEST(FitLaw, FindsALawAgainFromItsOwnCurves) {
  const HyperLaw truth{.name = "", .terms = {{4e4, 1.4}, {5e3, 5.5}, {8e3, -2.2}}};
  const LawFit fit = FitLaw(Family("ogden-3"), ThreeTests(truth));
  EXPECT_LT(fit.rms, 1e-5);
  EXPECT_NEAR(fit.law.ShearModulus() / truth.ShearModulus(), 1, 1e-3);
  const HyperLaw mooney{.name = "", .terms = {{4e4, 2}, {1e4, -2}}};
  const LawFit two = FitLaw(Family("mooney-rivlin"), ThreeTests(mooney));
  EXPECT_NEAR(two.values[0], 4e4, 1e-4);
  EXPECT_NEAR(two.values[1], 1e4, 1e-4);
}

TEST(FitLaws, ChooseTheLawThatMadeTheData) {
  const HyperLaw neo{.name = "", .terms = {{3e4, 2}}};
  EXPECT_EQ(FitLaws(ThreeTests(neo, 0.01)).front().law.name, "neo-hookean");
  const HyperLaw mooney{.name = "", .terms = {{3e4, 2}, {1e4, -2}}};
  EXPECT_EQ(FitLaws(ThreeTests(mooney, 0.005)).front().law.name, "mooney-rivlin");
}

// The same data give the same result in any unit.
TEST(FitLaws, DoNotDependOnTheUnit) {
  const HyperLaw law{.name = "", .terms = {{3e4, 1.5}, {2e3, 6}}};
  std::vector<MaterialTest> tests = ThreeTests(law, 0.01);
  const LawFit here = FitLaw(Family("ogden-2"), tests);
  for (MaterialTest& test : tests) {
    for (TestRow& row : test.rows) row.measured[0] *= 1e-6;
  }
  const LawFit there = FitLaw(Family("ogden-2"), tests);
  EXPECT_NEAR(1e6 * there.law.ShearModulus() / here.law.ShearModulus(), 1, 1e-6);
  EXPECT_NEAR(there.values[2], here.values[2], 1e-4);
}

// The curve softens in tension, like brain. Of the laws in the list only Ogden's with a negative
// exponent fits it with positive moduli and is stable, so it must come first.
TEST(FitLaws, NeverOfferAnUnstableLawBeforeAStableOne) {
  HyperLaw falling{.name = "", .yeoh = {3e4, -4e3, 0}};
  const std::vector<LawFit> fits = FitLaws({CurveOf(falling, TestKind::kUniaxial, 2.4, 40, 0.002)});
  EXPECT_EQ(fits.front().unstable, "");
  for (const LawFit& fit : fits) {
    if (fit.law.name != "yeoh") continue;
    EXPECT_NE(fit.unstable, "");
  }
}

// Neo-Hookean data need no second term: no selected law has a modulus that may be zero. Yeoh's law
// whose second modulus is zero is found without that term.
TEST(FitLaws, DropWhatMayBeZero) {
  const HyperLaw neo{.name = "", .terms = {{3e4, 2}}};
  std::vector<std::string> dropped;
  for (const LawFit& fit : FitLaws(ThreeTests(neo, 0.01), &dropped)) {
    for (Eigen::Index i = 0; i < fit.family.moduli(); ++i) {
      EXPECT_GT(std::abs(fit.values[i]), 1.96 * std::sqrt(fit.covariance(i, i))) << fit.law.name;
    }
  }
  EXPECT_THAT(dropped, testing::Contains(HasSubstr("mooney-rivlin G")));
  const HyperLaw stiffening{.name = "", .yeoh = {3e4, 0, 600}};
  const auto fits = FitLaws({CurveOf(stiffening, TestKind::kUniaxial, 2.5, 60, 0.01, 4)});
  EXPECT_EQ(fits.front().law.name, "yeoh without C2");
  EXPECT_NEAR(fits.front().values[1], 600, 60);
}

TEST(FitLaws, StateTheModulusAtRestWithItsSigma) {
  const HyperLaw mooney{.name = "", .terms = {{3e4, 2}, {1e4, -2}}};
  const LawFit fit = FitLaw(Family("mooney-rivlin"), ThreeTests(mooney, 0.01));
  const Eigen::Vector2d both(3, 3);  // E = 3 (G1 + G2)
  EXPECT_NEAR(fit.young_sigma / std::sqrt(both.dot(fit.covariance * both)), 1, 1e-4);
}

// The softer law's stress is 0.8 of the measured one, which therefore exceeds it by a quarter.
TEST(AtRest, StatesTheRelativeErrorOfTheLawAtSmallStrains) {
  const HyperLaw law{.name = "", .terms = {{3e4, 2}}}, softer{.name = "", .terms = {{2.4e4, 2}}};
  const MaterialTest test = CurveOf(law, TestKind::kUniaxial, 2, 100);
  EXPECT_NEAR(FindAtRest(law, {test}).off, 0, 1e-12);
  EXPECT_NEAR(FindAtRest(softer, {test}).off, 0.25, 1e-12);
  EXPECT_NEAR(FindAtRest(softer, {test}).excess(), 0.25, 1e-9);
  const MaterialTest noisy = CurveOf(law, TestKind::kUniaxial, 5, 50, 0.05);
  EXPECT_EQ(FindAtRest(law, {noisy}).excess(), 0);
}

// G (l - 1 / l^2) and 3 G (l - 1) differ by a tenth at l = 0.9066 and 1.1036.
TEST(LinearRange, IsThatOfTheNeoHookeanLaw) {
  const auto [low, high] = LinearRange({.name = "", .terms = {{3e4, 2}}});
  EXPECT_NEAR(low, 0.9066 - 1, 0.006);
  EXPECT_NEAR(high, 1.1036 - 1, 0.006);
}

TEST(ChordModulus, IsYoungsOfAStraightCurve) {
  MaterialTest test{.kind = TestKind::kUniaxial, .components = {{0, 0}}, .end_factor = 1.4};
  for (int i = 0; i <= 40; ++i) {
    test.rows.push_back({.abscissa = 1 - 0.01 * i, .measured = {-1.4 * 5e4 * 0.01 * i}});
  }
  const auto chord = ChordModulusOf(test);
  ASSERT_TRUE(chord);
  EXPECT_NEAR(chord->modulus, 5e4, 1e-6);
  EXPECT_TRUE(chord->compression);
  EXPECT_NEAR(chord->excess, 0, 1e-9);
}

// Stress 1e5 e^2: the chord between 10 and 20 % has the slope 3e4, hence 6 kPa at 20 %, where the
// line through these rows has 3.83 (mean square 0.02333 of the strain, 3e4 * 0.05 above it).
TEST(ChordModulus, StatesTheExcessOfALinearModel) {
  MaterialTest test{.kind = TestKind::kUniaxial, .components = {{0, 0}}};
  for (int i = 0; i <= 300; ++i) {
    const double strain = 0.001 * i;
    test.rows.push_back({.abscissa = 1 - strain, .measured = {-1e5 * strain * strain}});
  }
  EXPECT_NEAR(ChordModulusOf(test)->excess, 6 / 3.833 - 1, 0.01);
}

// Noise in the stresses spreads the moduli as much as stated. Tolerance: three standard deviations
// of a spread of 400 draws, 11 %.
TEST(ChordModulus, StatesTheSpreadOfTheModulus) {
  constexpr int kDraws = 400;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 200);  // [Pa]
  double sum = 0, square = 0, stated = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    MaterialTest test{.kind = TestKind::kUniaxial, .components = {{0, 0}}, .end_factor = 1.4};
    for (int i = 0; i <= 40; ++i) {
      test.rows.push_back(
          {.abscissa = 1 - 0.01 * i, .measured = {-1.4 * 5e4 * 0.01 * i + noise(random)}});
    }
    const auto chord = ChordModulusOf(test);
    ASSERT_TRUE(chord);
    sum += chord->modulus, square += chord->modulus * chord->modulus;
    stated += chord->sigma * chord->sigma;
  }
  const double mean = sum / kDraws;
  const double spread = std::sqrt((square - kDraws * mean * mean) / (kDraws - 1));
  EXPECT_NEAR(std::sqrt(stated / kDraws) / spread, 1, 0.11);
}

}  // namespace
}  // namespace palpate::identify
