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
