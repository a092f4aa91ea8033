#include "master/link/round_trips.h"

namespace palpate {
namespace {

constexpr double kMicro = 1e6;

}  // namespace

void RoundTrips::Restart() {
  const std::scoped_lock lock(mutex_);
  offset_ = {};
  state_sequence_ = command_sequence_ = 0;
  echo_.reset();
}

double RoundTrips::Arrived(const SlaveState& state, Time received_at) {
  const std::scoped_lock lock(mutex_);
  state_sequence_ = state.sequence;
  echo_ = state.sent_at;
  if (state.echo && state.command_sequence != command_sequence_) {  // one trip per command
    command_sequence_ = state.command_sequence;
    const Time taken_at = state.sent_at - Seconds(state.echo_delay);  // slave's clock
    rtt_.Add(kMicro * (SecondsBetween(*state.echo, received_at) - state.echo_delay));
    offset_.Add(*state.echo, taken_at, state.sent_at, received_at);
  }
  return offset_.seconds();
}

void RoundTrips::FillEcho(OperatorCommand* command) const {
  const std::scoped_lock lock(mutex_);
  command->state_sequence = state_sequence_;
  command->echo = echo_;
}

LatencyHistogram RoundTrips::rtt() const {
  const std::scoped_lock lock(mutex_);
  return rtt_;
}

double RoundTrips::clock_offset() const {
  const std::scoped_lock lock(mutex_);
  return offset_.seconds();
}

}  // namespace palpate
