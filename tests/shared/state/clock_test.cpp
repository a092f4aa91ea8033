#include "shared/state/clock.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(ClockTest, NeverRunsBackwards) {
  Time last = Clock::now();
  for (int i = 0; i < 100'000; ++i) {
    const Time now = Clock::now();
    ASSERT_GE(now, last);
    last = now;
  }
}

// Reference: the system's wall clock. Tolerance: it may be stepped by a few seconds meanwhile.
TEST(ClockTest, ReadsAsADate) {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  const auto difference = Clock::now().time_since_epoch() - wall;
  EXPECT_LT(std::chrono::abs(difference), std::chrono::seconds(10));
}

TEST(ClockTest, AnInstantIsTheSameOnTheSteadyClock) {
  const auto before = std::chrono::steady_clock::now();
  const Time now = Clock::now();
  const auto after = std::chrono::steady_clock::now();
  EXPECT_GE(Clock::ToSteady(now), before);
  EXPECT_LE(Clock::ToSteady(now), after);
}

TEST(ClockTest, SecondsThereAndBack) {
  const Time t{};
  EXPECT_DOUBLE_EQ(SecondsBetween(t, t + Seconds(1.5)), 1.5);
  EXPECT_DOUBLE_EQ(SecondsBetween(t + Seconds(1.5), t), -1.5);
}

}  // namespace
}  // namespace palpate
