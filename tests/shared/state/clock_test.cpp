#include "shared/state/clock.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(ClockTest, AnInstantIsTheSameOnTheSteadyClock) {
  const auto before = std::chrono::steady_clock::now();
  const Time now = Clock::now();
  const auto after = std::chrono::steady_clock::now();
  EXPECT_GE(Clock::ToSteady(now), before);
  EXPECT_LE(Clock::ToSteady(now), after);
}

}  // namespace
}  // namespace palpate
