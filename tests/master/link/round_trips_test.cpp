#include <gtest/gtest.h>

#include "master/link/operate_exchange.h"

namespace palpate {
namespace {

// A slave whose clock is 100 s ahead answers a command of the master: 3 ms to the slave, 10 ms in
// the slave, 5 ms back.
struct Exchange {
  Time sent_at{std::chrono::hours(1)};
  Time received_at = sent_at + Seconds(18e-3);
  SlaveState state;

  explicit Exchange(std::uint64_t sequence) {
    state.sequence = state.command_sequence = sequence;
    state.echo = sent_at;
    state.echo_delay = 10e-3;
    state.sent_at = sent_at + Seconds(100 + 3e-3 + 10e-3);
  }
};

// Reference: 3 ms + 5 ms, without the time in the slave. Tolerance: a histogram's bin is 2 %.
TEST(RoundTripsTest, TheTimeThatTheSlaveHeldACommandDoesNotCount) {
  RoundTrips trips;
  const Exchange exchange(1);
  trips.Arrived(exchange.state, exchange.received_at);
  EXPECT_NEAR(trips.times().rtt.max(), 8000, 1e-3);
}

// Reference: RFC 5905: the offset is wrong by half the difference of the two delays, 1 ms.
TEST(RoundTripsTest, TheSlavesClockIsFoundToHalfTheDifferenceOfTheWays) {
  RoundTrips trips;
  const Exchange exchange(1);
  EXPECT_NEAR(trips.Arrived(exchange.state, exchange.received_at), 100 - 1e-3, 1e-8);
  EXPECT_NEAR(trips.clock_offset(), 100 - 1e-3, 1e-8);
}

// Reference: 5 ms back, of which the clocks' offset misses 1 ms, as above; sensed 20 ms earlier.
TEST(RoundTripsTest, HowLongAStateTookAndHowOldItAndTheCommandAreIsReported) {
  RoundTrips trips;
  Exchange exchange(1);
  exchange.state.sensed_at = exchange.state.sent_at - Seconds(20e-3);
  trips.Arrived(exchange.state, exchange.received_at);
  EXPECT_NEAR(trips.times().delay.max(), 4000, 0.1);
  EXPECT_NEAR(trips.times().age.max(), 24000, 0.1);
  EXPECT_NEAR(trips.times().command_age.max(), 14000, 0.1);  // 3 ms there, 10 ms held, the 1 ms
}

TEST(RoundTripsTest, RepeatedStatesOfOneCommandAreOneTrip) {
  RoundTrips trips;
  for (int i = 0; i < 5; ++i) {
    const Exchange exchange(7);
    trips.Arrived(exchange.state, exchange.received_at);
  }
  EXPECT_EQ(trips.times().rtt.count(), 1U);
}

TEST(RoundTripsTest, ACommandEchoesNoStateOfAnotherStream) {
  RoundTrips trips;
  const Exchange exchange(3);
  trips.Arrived(exchange.state, exchange.received_at);
  OperatorCommand command;
  command.state_sequence = 2;  // the state that the loop used, not the newest one
  command.echo = exchange.state.sent_at;
  trips.DropOtherEcho(&command);
  EXPECT_EQ(command.state_sequence, 2U);
  EXPECT_EQ(command.echo, exchange.state.sent_at);
  trips.Restart();
  trips.DropOtherEcho(&command);
  EXPECT_EQ(command.state_sequence, 0U);
  EXPECT_FALSE(command.echo.has_value());
}

}  // namespace
}  // namespace palpate
