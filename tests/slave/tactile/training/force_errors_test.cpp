#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "slave/tactile/training/estimate_errors.h"

namespace palpate {
namespace {

using Forces = std::vector<Eigen::Vector3f>;

Forces Measured() {
  return {{0, 0.5F, -1}, {0, 1, -2}, {0, -0.5F, -4}, {0, 0, -1}};
}

TEST(CompareForcesTest, AnExactEstimateHasNoErrorAndCorrelationOne) {
  const ForceErrors errors = CompareForces(Measured(), Measured());
  EXPECT_EQ(errors.count, 4U);
  EXPECT_EQ(errors.rmse.norm(), 0);
  EXPECT_EQ(errors.smse.z(), 0);
  EXPECT_NEAR(errors.correlation.y(), 1, 1e-12);
  EXPECT_NEAR(errors.correlation.z(), 1, 1e-12);
  EXPECT_TRUE(std::isnan(errors.smse.x()));  // fx did not vary: nothing to compare with
}

// Law: who always says the mean has a standardised error of exactly 1, in any unit.
TEST(CompareForcesTest, WhoAlwaysSaysTheMeanHasAStandardisedErrorOfOne) {
  const ForceErrors errors = CompareForces(Forces(4, {0, 0.25F, -2}), Measured());
  EXPECT_NEAR(errors.smse.y(), 1, 1e-12);
  EXPECT_NEAR(errors.smse.z(), 1, 1e-12);
  EXPECT_TRUE(std::isnan(errors.correlation.z()));
}

// By hand: errors of fz are 0.1, 0, -0.5, 0; the peak is 4 N.
TEST(CompareForcesTest, PeakAndWorstAreThoseOfTheCurve) {
  Forces estimated = Measured();
  estimated[0].z() += 0.1F;
  estimated[2].z() -= 0.5F;
  const ForceErrors errors = CompareForces(estimated, Measured());
  EXPECT_NEAR(errors.rmse.z(), std::sqrt(0.26 / 4), 1e-7);
  EXPECT_NEAR(errors.smse.z(), 0.26 / 4 / 1.5, 1e-7);
  EXPECT_NEAR(errors.peak.z(), 4, 1e-12);
  EXPECT_NEAR(errors.at_peak.z(), 0.5, 1e-7);
  EXPECT_NEAR(errors.worst.z(), 0.5, 1e-7);
}

// Of two sizes, errors of variances that grow with the size, or with its square, or both: each is
// told as it is.
TEST(CompareForcesTest, HowErrorsGrowWithTheForceIsTold) {
  const auto compared = [](float at_one, float at_four) {
    const Forces measured{{0, 0, -1}, {0, 0, -4}};
    return CompareForces(Forces{{at_one, 0, -1}, {0, at_four, -4}}, measured);
  };
  const ForceErrors grows = compared(0.1F, 0.2F);  // variances 0.01 and 0.04
  EXPECT_NEAR(grows.law.growing, 0.01, 1e-8);
  EXPECT_NEAR(grows.law.relative, 0, 1e-4);
  const ForceErrors in_parts = compared(0.1F, 0.4F);  // 0.01 and 0.16
  EXPECT_NEAR(in_parts.law.growing, 0, 1e-8);
  EXPECT_NEAR(in_parts.law.relative, 0.1, 1e-7);
  const ForceErrors both = compared(0.1F, 0.3F);  // 0.01 = g + r, 0.09 = 4 g + 16 r
  EXPECT_NEAR(both.law.growing, 0.07 / 12, 1e-8);
  EXPECT_NEAR(both.law.relative, std::sqrt(0.05 / 12), 1e-6);
  // Grows less than either: as |f|, and large enough for that of one newton.
  const ForceErrors the_same = compared(0.1F, 0.1F);
  EXPECT_NEAR(the_same.law.growing, 0.01, 1e-8);
  EXPECT_EQ(the_same.law.relative, 0);
}

// A few large errors leave one sigma where two thirds of them are.
TEST(CompareForcesTest, TwoThirdsOfTheErrorsAreWithinOneSigma) {
  const Forces measured(100, {0, 0, -2});
  Forces estimated = measured;
  for (std::size_t i = 0; i < 100; ++i) estimated[i].x() = i < 70 ? 0.1F : 0.8F;
  EXPECT_NEAR(CompareForces(estimated, measured).law.relative, 0.05, 1e-6);
}

TEST(CompareForcesTest, ForcesOfOneSizeTellNoGrowth) {
  const Forces measured(3, {0, 0, -2});
  const ForceErrors errors = CompareForces(Forces(3, {0.2F, 0, -2}), measured);
  EXPECT_EQ(errors.law.growing, 0);
  EXPECT_NEAR(errors.law.relative, 0.1, 1e-7);
}

TEST(CompareForcesTest, NothingComparedGivesNothing) {
  EXPECT_EQ(CompareForces({}, {}).count, 0U);
}

TEST(FitForceGainTest, RecoversTheFactorAndIgnoresTheOtherAxes) {
  Forces estimated = Measured();
  for (auto& f : estimated) f = {7, -3, f.z() / 1.47F};
  EXPECT_NEAR(FitForceGain(estimated, Measured()), 1.47, 1e-6);
}

TEST(FitForceGainTest, RefusesTheOtherSignAndSilence) {
  Forces flipped = Measured();
  for (auto& f : flipped) f = -f;
  EXPECT_THROW(FitForceGain(flipped, Measured()), std::invalid_argument);
  EXPECT_THROW(FitForceGain(Forces(4, {0, 0, 0}), Measured()), std::invalid_argument);
  EXPECT_THROW(FitForceGain({}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
