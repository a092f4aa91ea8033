#include <gtest/gtest.h>

#include "master/station/tick_digest.h"

namespace palpate {
namespace {

constexpr Time kSensed{std::chrono::seconds(1'700'000'000)};  // slave's clock
constexpr double kOffset = 3;                                 // slave's minus master's [s]

// Reference: instants that are chosen; each stage lies between two of them.
TEST(HandTraceTest, EachStageIsReportedAndTheyAreAllThereIs) {
  const auto after = [](double t) { return kSensed + Seconds(t); };
  const SampleTrace sample{41, kSensed, after(0.001), after(0.006), after(0.0065)};
  TickRecord tick;
  tick.at = after(0.0100 - kOffset);
  tick.state_sequence = 900;
  tick.sensed_at = kSensed;
  tick.sent_at = after(0.0085);
  tick.state_age = 0.0005;  // it came at 9.5 ms
  tick.sensed_age = 0.0100;
  const auto trace = TraceOf(tick, 12.5, sample);
  ASSERT_TRUE(trace);
  EXPECT_EQ(trace->sample, 41U);
  EXPECT_EQ(trace->state, 900U);
  EXPECT_EQ(trace->t, 12.5);
  EXPECT_NEAR(trace->capture, 0.001, 1e-9);
  EXPECT_NEAR(trace->sensing, 0.005, 1e-9);
  EXPECT_NEAR(trace->model, 0.0005, 1e-9);
  EXPECT_NEAR(trace->wait, 0.002, 1e-9);
  EXPECT_NEAR(trace->wire, 0.001, 1e-9);
  EXPECT_NEAR(trace->tick, 0.0005, 1e-9);
  EXPECT_NEAR(
      trace->capture + trace->sensing + trace->model + trace->wait + trace->wire + trace->tick,
      trace->total, 1e-12);
}

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
