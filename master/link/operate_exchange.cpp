#include "master/link/operate_exchange.h"

#include <algorithm>
#include <utility>

#include "shared/validation/validation.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr double kMicro = 1e6;

}  // namespace

void RoundTrips::Restart() {
  const std::scoped_lock lock(mutex_);
  offset_ = {};
  state_sequence_ = command_sequence_ = 0;
  newest_ = 0;
}

double RoundTrips::Arrived(const SlaveState& state, Time received_at) {
  const std::scoped_lock lock(mutex_);
  state_sequence_ = state.sequence;
  if (state.echo && state.command_sequence != command_sequence_) {  // one trip per command
    command_sequence_ = state.command_sequence;
    const Time taken_at = state.sent_at - Seconds(state.echo_delay);  // slave's clock
    newest_ = std::max(0.0, SecondsBetween(*state.echo, received_at) - state.echo_delay);
    times_.rtt.Add(kMicro * newest_);
    offset_.Add(*state.echo, taken_at, state.sent_at, received_at);
  }
  const double offset = offset_.seconds();
  if (offset_.known()) {
    times_.delay.Add(kMicro * (SecondsBetween(state.sent_at, received_at) + offset));
    times_.age.Add(kMicro * (SecondsBetween(state.sensed_at, received_at) + offset));
    if (state.echo) {
      times_.command_age.Add(kMicro * (SecondsBetween(*state.echo, state.sent_at) - offset));
    }
  }
  return offset;
}

void RoundTrips::DropOtherEcho(OperatorCommand* command) const {
  const std::scoped_lock lock(mutex_);
  if (command->state_sequence <= state_sequence_) return;
  command->state_sequence = 0;
  command->echo.reset();
}

double RoundTrips::newest() const {
  const std::scoped_lock lock(mutex_);
  return newest_;
}

RoundTrips::Times RoundTrips::times() const {
  const std::scoped_lock lock(mutex_);
  return times_;
}

double RoundTrips::clock_offset() const {
  const std::scoped_lock lock(mutex_);
  return offset_.seconds();
}

OperateExchange::OperateExchange(Surroundings surroundings) : with_(std::move(surroundings)) {
  with_.commands.Take();
  with_.trips.Restart();
}

std::optional<OperatorCommand> OperateExchange::NextCommand(Time now) {
  const OperatorCommand* newest = with_.commands.Take();
  if (newest == nullptr) return std::nullopt;
  OperatorCommand command = *newest;
  with_.trips.DropOtherEcho(&command);
  command.sent_at = now;
  Validate(command, "OperateExchange::NextCommand");
  return command;
}

bool OperateExchange::TakeFromStream(std::shared_ptr<v1::SlaveState> message, Time now) {
  std::string reason;
  const auto state = FromProto(*message, &reason);
  const std::scoped_lock lock(mutex_);
  if (!state) {
    with_.on_refused_state(reason);
    return false;
  }
  if (state->sequence <= stream_sequence_) return true;
  stream_sequence_ = state->sequence;
  if (!PutIfNewer(*state, std::move(message), now)) overtaken_.Add(state->events);
  return true;
}

bool OperateExchange::TakeDatagram(std::shared_ptr<v1::SlaveState> message, Time now) {
  std::string reason;
  const auto state = FromProto(*message, &reason);
  const std::scoped_lock lock(mutex_);
  if (is_over_) return false;
  if (!state) {
    with_.on_refused_state(reason);
    return false;
  }
  if (PutIfNewer(*state, std::move(message), now)) ++with_.states_by_datagram;
  return true;
}

void OperateExchange::End() {
  const std::scoped_lock lock(mutex_);
  is_over_ = true;
  last_.ended = true;
  if (last_sequence_ != 0) with_.states.Put(last_);
}

bool OperateExchange::was_served() const {
  const std::scoped_lock lock(mutex_);
  return last_sequence_ != 0;
}

bool OperateExchange::PutIfNewer(SlaveState state, std::shared_ptr<v1::SlaveState> message,
                                 Time now) {
  if (state.sequence <= last_sequence_) return false;
  if (std::exchange(last_sequence_, state.sequence) == 0) with_.on_first_state();
  ++with_.states_received;
  if (const Events overtaken = std::exchange(overtaken_, {}); !overtaken.empty()) {
    state.events.Add(overtaken);
    ToProto(state.events, message->mutable_events());
  }

  last_ = {state, now, with_.trips.Arrived(state, now), with_.trips.newest()};
  with_.on_state(state, {std::move(message), now});
  with_.states.Put(last_);
  return true;
}

}  // namespace palpate
