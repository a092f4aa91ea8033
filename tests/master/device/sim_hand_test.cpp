#include "master/device/sim_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <gtest/gtest.h>

namespace palpate {
namespace {

const Eigen::Vector3d kHandInward(0, -1, 0);
constexpr double kGap = 0.004;    // [m]
constexpr double kDepth = 0.005;  // [m]

// Makes the simulated operator press a wall of stiffness `K` [N/m] for `seconds`. Returns the depth
// of each millisecond.
std::vector<double> Press(SimHand& hand, double K, double seconds, double force_limit) {
  std::vector<double> depths;
  const Time start{std::chrono::hours(1)};
  for (int i = 0; i < seconds * 1000; ++i) {
    const DeviceReading reading = hand.Read(start + std::chrono::milliseconds(i));
    const double depth = reading.p_M.dot(kHandInward) - kGap;
    hand.WriteForce(-kHandInward * std::min(std::max(0.0, K * depth), force_limit));
    hand.Guide({true, kHandInward, -depth});
    depths.push_back(depth);
  }
  return depths;
}

class SimHandWallTest : public testing::TestWithParam<double> {};

// Reference: the depth requested. The correction's pole lies at 8 k / (k + K) per second; for
// K = 1000 N/m, the hold of 1 s closes the gap of K / (k + K) to exp(-3.6) of it: 0.08 mm.
TEST_P(SimHandWallTest, ReachesTheDepthInSpiteOfTheForce) {
  SimHand hand(kDepth, 0.020);
  const auto depths = Press(hand, GetParam(), 4, 100);
  EXPECT_NEAR(*std::max_element(depths.begin(), depths.end()), kDepth, 0.0001);
  EXPECT_NEAR(depths.back(), -kGap, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Stiffness, SimHandWallTest, testing::Values(0, 100, 480, 1000));

// Reference: statics. The arm aims at most kStrength / k too deep, and the force stops rising.
TEST(SimHandTest, DoesNotWindUpAgainstAForceItCannotOvercome) {
  SimHand hand(kDepth, 0.020);
  const auto depths = Press(hand, 1e5, 4, 20);
  EXPECT_LT(*std::max_element(depths.begin(), depths.end()), kDepth);
  EXPECT_NEAR(depths.back(), -kGap, 1e-6);
}

// Reference: a constant force moves the resting arm by f / k.
TEST(SimHandTest, YieldsToAForceByItsStiffness) {
  SimHand hand(kDepth, 0.020);
  const Time start{std::chrono::hours(1)};
  DeviceReading reading;
  for (int i = 0; i <= 900; ++i) {
    hand.WriteForce({0, 0.8, 0});
    reading = hand.Read(start + std::chrono::milliseconds(i));
  }
  EXPECT_NEAR(reading.p_M.y(), 0.8 / 800, 1e-6);
}

// A force that is not renewed ends after 20 ms, because the loop that wrote it may have stopped.
// Reference: impulse. In that time the arm at rest gains the speed F t / m, reduced by a third by
// spring and damper.
TEST(SimHandTest, EndsAForceThatIsNotRenewed) {
  SimHand hand(kDepth, 0.020);
  const Time start{std::chrono::hours(1)};
  std::ignore = hand.Read(start);
  hand.WriteForce({0, 1.05, 0});
  double fastest_at = 0, fastest = 0, last = 0;
  for (int i = 1; i <= 150; ++i) {
    const DeviceReading reading = hand.Read(start + std::chrono::milliseconds(i));
    if (reading.v_M.y() > fastest) {
      fastest = reading.v_M.y();
      fastest_at = i;
    }
    last = reading.p_M.y();
  }
  EXPECT_NEAR(fastest_at, 20, 1);
  EXPECT_LT(fastest, 1.05 * 0.020 / 0.3);
  EXPECT_LT(std::abs(last), 0.1 * 1.05 / 800) << "the arm is back";
}

TEST(SimHandTest, StaysFiniteForAnyForceAndAnyPause) {
  SimHand hand(kDepth, 0.020);
  Time now{std::chrono::hours(1)};
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 0.0}) {
    hand.WriteForce({bad, 0, 0});
    hand.Guide({true, {0, bad, 0}, bad});
    for (const auto gap : {std::chrono::milliseconds(1), std::chrono::milliseconds(3600000)}) {
      now += gap;
      const DeviceReading reading = hand.Read(now);
      EXPECT_TRUE(reading.p_M.allFinite() && reading.v_M.allFinite());
      EXPECT_LT(reading.p_M.norm(), 0.1);
    }
  }
}

}  // namespace
}  // namespace palpate
