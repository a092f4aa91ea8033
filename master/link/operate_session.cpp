#include "master/link/operate_session.h"

#include <limits>
#include <thread>
#include <utility>

#include <netinet/in.h>

#include "shared/link/tcp_line.h"
#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr double kMicro = 1e6, kMilli = 1e-3;

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

grpc::Status OperateSession::Run(const std::stop_token& stop) {
  with_.commands.Take();  // discards a command of the previous stream
  with_.trips.Restart();
  heard_at_ = Clock::now() + first_within_;
  const auto stream = with_.stub.Operate(&context_);
  std::jthread sender([&](const std::stop_token& ended) {
    std::stop_source either;
    const std::stop_callback on_stop(stop, [&] { either.request_stop(); });
    const std::stop_callback on_end(ended, [&] { either.request_stop(); });
    SendCommands(stream.get(), either.get_token());
  });
  v1::SlaveState message;
  bool is_first = true;
  while (stream->Read(&message)) {
    if (std::exchange(is_first, false)) {
      if (const auto shown = FactsOf(*context_.auth_context())) trusted_until_ = shown->until;
    }
    ReceiveFromStream(message);
  }
  {
    // The haptic loop learns of the end at once, and no later state is accepted.
    const std::scoped_lock lock(mutex_);
    is_over_ = true;
    last_.ended = true;
    if (was_served()) Put(last_);
  }
  sender.request_stop();
  sender.join();
  line_.reset();
  grpc::Status status = stream->Finish();
  if (expired_)
    return {grpc::StatusCode::UNAVAILABLE, "the slave's certificate is no longer valid"};
  if (!silent_) return status;
  return {grpc::StatusCode::UNAVAILABLE, Formatted("no state for %.3g s: the link has timed out",
                                                   kMilli * static_cast<double>(silence_.count()))};
}

void OperateSession::SendCommands(Stream* stream, const std::stop_token& stop) {
  MakeThreadRealtime(kLinkPriority);
  for (auto wake = Clock::now(); !stop.stop_requested(); wake += kCommandPeriod) {
    std::this_thread::sleep_until(Clock::ToSteady(wake));
    const Time now = Clock::now();
    if (now - wake > kCommandPeriod) wake = now;  // skip missed periods
    if (!MayGoOn(now)) break;
    SendNewest(stream);
  }
  writer_.reset();  // its thread uses the stream and the line of datagrams
  stream->WritesDone();
}

bool OperateSession::MayGoOn(Time now) {
  silent_ = now - heard_at_.load() > silence_;
  expired_ = std::chrono::system_clock::now() >= trusted_until_.load();
  if (!silent_ && !expired_) return true;
  context_.TryCancel();
  return false;
}

void OperateSession::SendNewest(Stream* stream) {
  // A command is not repeated, so that the slave notices a stopped haptic loop.
  const OperatorCommand* newest = with_.commands.Take();
  if (newest == nullptr) return;
  OperatorCommand command = *newest;
  with_.trips.DropOtherEcho(&command);
  command.sent_at = Clock::now();
  ToProto(command, &message_);
  if (!std::exchange(is_introduced_, true)) {
    message_.set_operator_name(operator_name_);
    message_.set_datagrams(datagrams_requested_);
  }
  DatagramLine* line = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    line = line_.get();
  }
  if (line != nullptr) {
    ToProto(line->seen(), message_.mutable_datagrams_seen());
    line->Send(message_.SerializeAsString());
    message_.clear_datagrams_seen();
    if (!writer_) writer_.emplace(stream, [line] { line->StreamMoves(); });
    writer_->Put(message_);
  } else if (!stream->Write(message_)) {
    return;
  }
  ++with_.commands_sent;
  if (with_.on_sent) with_.on_sent(command);
}

void OperateSession::ReceiveFromStream(const v1::SlaveState& message) {
  const Time now = Clock::now();
  if (message.has_datagrams()) OpenDatagrams(message.datagrams());
  std::string reason;
  const auto state = FromProto(message, &reason);
  const std::scoped_lock lock(mutex_);
  if (!state) return with_.on_refused_state(reason);
  if (state->sequence <= stream_sequence_) return;
  stream_sequence_ = state->sequence;
  heard_at_ = now;  // datagrams keep no stream alive
  if (!TakeIfNewer(*state, now)) overtaken_.Add(state->events);
}

DatagramLine::LinkFeedback OperateSession::ReceiveDatagram(std::string_view plain) {
  const Time now = Clock::now();
  if (!datagram_.ParseFromArray(plain.data(), static_cast<int>(plain.size()))) return {};
  std::string reason;
  const auto state = FromProto(datagram_, &reason);
  const std::scoped_lock lock(mutex_);
  if (is_over_) return {};
  if (!state) {
    with_.on_refused_state(reason);
    return {};
  }
  with_.datagram_at = now;
  if (TakeIfNewer(*state, now)) ++with_.states_by_datagram;
  return {FromProto(datagram_.datagrams_seen()), with_.trips.newest()};
}

// Uses only the address of the stream, so that a slave cannot make the master flood another
// machine. If this fails, the stream continues alone.
void OperateSession::OpenDatagrams(const v1::DatagramOffer& offer) {
  const auto to_send = DatagramKeyFrom(offer.command_key());
  const auto to_receive = DatagramKeyFrom(offer.state_key());
  const auto ends = EndsOf(context_.peer());
  const bool is_port = offer.port() >= 1 && offer.port() <= std::numeric_limits<in_port_t>::max();
  if (!datagrams_requested_ || line_ || !to_send || !to_receive || !ends || !is_port) return;
  sockaddr_storage far = ends->far;
  reinterpret_cast<sockaddr_in6&>(far).sin6_port =  // same offset as in sockaddr_in
      htons(static_cast<in_port_t>(offer.port()));
  try {
    auto line = std::make_unique<DatagramLine>(
        DatagramLine::Role::kCalls, far, DatagramLine::Keys{*to_send, *to_receive},
        [this](std::string_view plain) { return ReceiveDatagram(plain); });
    const std::scoped_lock lock(mutex_);
    line_ = std::move(line);
  } catch (const std::exception&) {  // no socket or cipher: SlaveLink reports missing datagrams
    return;
  }
}

bool OperateSession::TakeIfNewer(const SlaveState& state, Time now) {
  if (state.sequence <= last_sequence_) return false;
  if (!std::exchange(served_, true)) with_.on_first_state();
  last_sequence_ = state.sequence;
  with_.on_state(state.settings_revision);
  ++with_.states_received;

  last_ = {state, now, with_.trips.Arrived(state, now), with_.trips.newest()};
  last_.state.events.Add(std::exchange(overtaken_, {}));
  if (with_.on_received) with_.on_received(last_);
  Put(last_);
  return true;
}

void OperateSession::Put(ReceivedState received) {
  // Events of a skipped state are added to the next one, at worst twice.
  if (with_.states.untaken()) received.state.events.Add(untaken_);
  untaken_ = received.state.events;
  with_.states.Put(received);
}

}  // namespace palpate
