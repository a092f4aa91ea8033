#include "slave/site/fingertips/simulated_presses.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace palpate {
namespace {

SimulatedPresses Few(int presses, std::uint64_t seed) {
  return {.presses = presses, .seed = seed};
}

// A contact is a run of samples with a force.
int CountContacts(const SimulatedStart& start) {
  int contacts = 0;
  for (std::size_t i = 1; i < start.force.size(); ++i) {
    contacts += !start.force[i - 1].any() && start.force[i].any() ? 1 : 0;
  }
  return contacts;
}

TEST(SimulatedPressesTest, EveryStartHasItsContacts) {
  const SimulatedPresses presses = Few(12, 1);
  ASSERT_EQ(CountStarts(presses), 3);
  EXPECT_EQ(CountContacts(SimulateStart(presses, 0)), 5);
  EXPECT_EQ(CountContacts(SimulateStart(presses, 1)), 5);
  EXPECT_EQ(CountContacts(SimulateStart(presses, 2)), 2);
}

TEST(SimulatedPressesTest, TheSameSeedGivesTheSameContacts) {
  const SimulatedStart a = SimulateStart(Few(5, 3), 0), b = SimulateStart(Few(10, 3), 0),
                       c = SimulateStart(Few(5, 4), 0), d = SimulateStart(Few(10, 3), 1);
  EXPECT_EQ(a.force, b.force);
  EXPECT_EQ(a.readings.back().electrodes, b.readings.back().electrodes);
  EXPECT_NE(a.force, c.force);
  EXPECT_NE(b.force, d.force);
}

// The fingertip pushes the object away from the pad: fz on the object is negative in the mean;
// normal forces stay below 5 N, tangential ones below half of that in each direction.
TEST(SimulatedPressesTest, ForcesFillTheRangeAndPointAwayFromThePad) {
  const SimulatedPresses presses = Few(200, 1);
  double largest = 0, sum_z = 0;
  for (int k = 0; k < CountStarts(presses); ++k) {
    for (const Eigen::Vector3d& f : SimulateStart(presses, k).force) {
      largest = std::max(largest, f.norm());
      sum_z += f.z();
    }
  }
  EXPECT_GT(largest, 4);
  EXPECT_LT(largest, 5 * std::sqrt(1.5));
  EXPECT_LT(sum_z, 0);
}

// Tolerance: twelve sigma of the fingertip's noise, because both samples have it.
TEST(SimulatedPressesTest, BeforeTheFirstContactSignalsAreAtRest) {
  for (int k = 0; k < 4; ++k) {
    const SimulatedStart start = SimulateStart(Few(20, 2), k);
    for (std::size_t i = 0; i < 60; ++i) {
      EXPECT_FALSE(start.force[i].any());
      for (std::size_t e = 0; e < kElectrodeCount; ++e) {
        EXPECT_LT(std::abs(start.readings[i].electrodes[e] - start.readings[0].electrodes[e]), 16);
      }
    }
  }
}

TEST(SimulatedPressesTest, NoPressesAndNoForceAreRefused) {
  EXPECT_THROW(CountStarts(Few(0, 1)), std::invalid_argument);
  EXPECT_THROW(CountStarts({.presses = 1, .largest_force = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
