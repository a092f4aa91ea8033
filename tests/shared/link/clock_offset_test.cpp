#include "shared/link/clock_offset.h"

#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Round trips between two simulated clocks that are `offset` apart.
class TwoClocks {
 public:
  explicit TwoClocks(double offset) : offset_(offset) {}
  // Simulates a request that takes `there` [s] and an answer that takes `back` [s], 1 ms after the
  // last round trip.
  void RoundTrip(ClockOffset* estimate, double there, double back) {
    now_ += Seconds(1e-3);
    const Time t1 = now_;
    const Time t2 = t1 + Seconds(there + offset_);
    const Time t3 = t2 + Seconds(0.5e-3);
    const Time t4 = t1 + Seconds(there + 0.5e-3 + back);
    estimate->Add(t1, t2, t3, t4);
    now_ = t4;
  }
  void Wait(double seconds) { now_ += Seconds(seconds); }
  void Shift(double seconds) { offset_ += seconds; }

 private:
  double offset_;
  Time now_{std::chrono::hours(24 * 365 * 50)};
};

// Reference: RFC 5905: |error| <= delta / 2, however the delay is split between both directions.
// The seed is fixed.
TEST(ClockOffsetTest, TheErrorStaysWithinWhatItSays) {
  std::mt19937 random(3);
  std::exponential_distribution<double> delay(1 / 5e-3);
  TwoClocks clocks(1.25);
  ClockOffset estimate;
  for (int i = 0; i < 500; ++i) {
    clocks.RoundTrip(&estimate, 1e-3 + delay(random), 1e-3 + delay(random));
    ASSERT_LE(std::abs(estimate.seconds() - 1.25), estimate.error() + 1e-8) << "trip " << i;
  }
}

TEST(ClockOffsetTest, TheFastestTripIsBelieved) {
  TwoClocks clocks(1);
  ClockOffset estimate;
  clocks.RoundTrip(&estimate, 50e-3, 1e-3);
  // One slow direction: the error is half its delay.
  EXPECT_GT(std::abs(estimate.seconds() - 1), 20e-3);
  clocks.RoundTrip(&estimate, 1e-3, 1e-3);
  clocks.RoundTrip(&estimate, 50e-3, 1e-3);
  EXPECT_NEAR(estimate.seconds(), 1, 1e-8);
}

TEST(ClockOffsetTest, OnceSettledItSlewsAndNeverSteps) {
  TwoClocks clocks(0);
  ClockOffset estimate;
  for (std::size_t i = 0; i < ClockOffset::kWindow; ++i) clocks.RoundTrip(&estimate, 1e-3, 1e-3);
  clocks.Shift(1e-3);
  double last = estimate.seconds();
  for (int i = 0; i < 1000; ++i) {
    clocks.RoundTrip(&estimate, 1e-3, 1e-3);
    // 3.5 ms from trip to trip.
    ASSERT_LE(std::abs(estimate.seconds() - last), ClockOffset::kSlew * 3.5e-3 + 1e-9);
    last = estimate.seconds();
  }
  EXPECT_NEAR(estimate.seconds(), 1e-3, 1e-6) << "it never arrived";
}

// A machine was suspended for ten minutes, during which its clock was stopped.
TEST(ClockOffsetTest, AClockThatStoodStillIsFoundAgainAtOnce) {
  for (const double slept : {-600.0, 600.0}) {
    TwoClocks clocks(0);
    ClockOffset estimate;
    for (std::size_t i = 0; i < 2 * ClockOffset::kWindow; ++i) {
      clocks.RoundTrip(&estimate, 1e-3, 1e-3);
    }
    clocks.Shift(slept);
    for (int i = 0; i < ClockOffset::kLeapSamples; ++i) clocks.RoundTrip(&estimate, 1e-3, 1e-3);
    EXPECT_NEAR(estimate.seconds(), slept, 1e-6);
  }
}

// Reference: RFC 5905: a round trip of 1 s with unequal delays may be wrong by half of it.
TEST(ClockOffsetTest, SlowTripsDoNotMoveTheOffset) {
  TwoClocks clocks(0);
  ClockOffset estimate;
  for (std::size_t i = 0; i < ClockOffset::kWindow; ++i) clocks.RoundTrip(&estimate, 1e-3, 1e-3);
  for (std::size_t i = 0; i < ClockOffset::kWindow - 1; ++i) {
    clocks.RoundTrip(&estimate, 1, 1e-3);
    ASSERT_NEAR(estimate.seconds(), 0, 1e-3);
  }
}

// An old sample loses 50 us per second: a slightly slower but new one must win in the end.
TEST(ClockOffsetTest, AnOldSampleLosesToANewOne) {
  TwoClocks clocks(0);
  ClockOffset estimate;
  clocks.RoundTrip(&estimate, 1e-3, 1e-3);
  clocks.Shift(40e-6);
  clocks.RoundTrip(&estimate, 1.05e-3, 1.05e-3);
  EXPECT_NEAR(estimate.seconds(), 0, 1e-8);
  clocks.Wait(5);
  clocks.RoundTrip(&estimate, 1.05e-3, 1.05e-3);
  EXPECT_NEAR(estimate.seconds(), 40e-6, 1e-8);
}

TEST(ClockOffsetTest, AnImpossibleTripIsLeftOut) {
  ClockOffset estimate;
  const Time t{};
  estimate.Add(t + Seconds(2), t, t, t + Seconds(1));  // arrived before it was sent
  EXPECT_FALSE(estimate.known());
  EXPECT_EQ(estimate.seconds(), 0);
}

}  // namespace
}  // namespace palpate
