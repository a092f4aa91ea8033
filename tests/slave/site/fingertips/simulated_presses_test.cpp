#include "slave/site/fingertips/simulated_presses.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace palpate {
namespace {

SimulatedPresses Few(int presses, std::uint64_t seed) {
  SimulatedPresses options;
  options.presses = presses;
  options.seed = seed;
  return options;
}

TEST(SimulatePressesTest, EveryStartIsARecordingWithItsPresses) {
  const auto recordings = SimulatePresses(Few(12, 1));
  ASSERT_EQ(recordings.size(), 3U);  // 5, 5 and 2 presses
  for (const LabelledRecording& r : recordings) {
    EXPECT_EQ(r.end, r.t.size());
    EXPECT_EQ(r.change.size(), r.t.size());
    EXPECT_EQ(r.force.size(), r.t.size());
  }
  // A third of them are gentler than what counts as contact beside the strongest.
  EXPECT_GE(FindPresses(recordings).size(), 6U);
  EXPECT_LE(FindPresses(recordings).size(), 12U);
}

TEST(SimulatePressesTest, TheSameSeedPressesInTheSameWay) {
  const auto a = SimulatePresses(Few(5, 3)), b = SimulatePresses(Few(10, 3)),
             c = SimulatePresses(Few(5, 4));
  EXPECT_EQ(a[0].change, b[0].change);
  EXPECT_EQ(a[0].force, b[0].force);
  EXPECT_NE(a[0].change, c[0].change);
  EXPECT_NE(b[0].force, b[1].force);
}

// Presses push the object away from the pad: fz of the fingertip on the object is negative in the
// mean; normal forces stay below 5 N, tangential ones below half of that in each direction.
TEST(SimulatePressesTest, ForcesFillTheRangeAndPointAwayFromThePad) {
  const auto recordings = SimulatePresses(Few(200, 1));
  float largest = 0, sum_z = 0;
  for (const LabelledRecording& r : recordings) {
    for (const Eigen::Vector3f& f : r.force) {
      largest = std::max(largest, f.norm());
      sum_z += f.z();
    }
  }
  EXPECT_GT(largest, 4);
  EXPECT_LT(largest, 5 * std::sqrt(1.5F));
  EXPECT_LT(sum_z, 0);
}

TEST(SimulatePressesTest, BeforeTheFirstPressSignalsAreAtRest) {
  for (const LabelledRecording& r : SimulatePresses(Few(20, 2))) {
    for (std::size_t i = 0; i < 60; ++i) {
      EXPECT_EQ(r.force[i].norm(), 0);
      // Six sigma of the fingertip's noise.
      for (std::size_t e = 0; e < kElectrodeCount; ++e) EXPECT_LT(std::abs(r.change[i][e]), 8);
    }
  }
}

TEST(SimulatePressesTest, RefusesNoPressesAndNoForce) {
  EXPECT_THROW(SimulatePresses(Few(0, 1)), std::invalid_argument);
  SimulatedPresses weak = Few(1, 1);
  weak.largest_force = 0;
  EXPECT_THROW(SimulatePresses(weak), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
