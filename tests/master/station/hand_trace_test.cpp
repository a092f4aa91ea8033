#include <gtest/gtest.h>

#include "master/station/tick_digest.h"

namespace palpate {
namespace {

constexpr Time kSensed{std::chrono::seconds(1'700'000'000)};  // slave's clock
constexpr double kOffset = 3;                                 // slave's minus master's [s]

TEST(HandTraceTest, NoTickIsGivenTheTraceOfAnotherSample) {
  TickRecord tick;
  tick.sensed_age = 0.01;
  tick.sensed_at = kSensed;
  EXPECT_TRUE(TraceOf(tick, 0, {1, kSensed}));
  EXPECT_FALSE(TraceOf(tick, 0, {1, kSensed + Seconds(1e-9)}));
  tick.sensed_age = -1;
  EXPECT_FALSE(TraceOf(tick, 0, {1, kSensed})) << "no state came yet";
}

}  // namespace
}  // namespace palpate
