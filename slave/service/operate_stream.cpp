#include "slave/service/operate_stream.h"

#include <variant>

#include <spdlog/spdlog.h>

#include "shared/link/tcp_line.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"
#include "slave/service/roles.h"

namespace palpate {
namespace {

constexpr double kCommandRate = 256e3;  // 80 kB/s are usual [bytes/s]
using OperateReactor = grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>;

}  // namespace

OperateReactor* OperateStream::Open(const Host& host, const grpc::ServerContextBase& context) {
  const std::shared_ptr<OperateStream> stream(new OperateStream(host, context));
  stream->self_ = stream;
  const grpc::Status refused = stream->RequestLease(OperatorNameOf(context));
  if (!refused.ok()) {
    stream->self_.reset();
    return new RefusedStream<OperateReactor>(refused);
  }
  stream->Read(&stream->command_);
  return stream.get();
}

grpc::Status OperateStream::RequestLease(const std::optional<std::string>& name) {
  const auto self = std::static_pointer_cast<OperateStream>(self_);
  const auto dismiss = [weak = std::weak_ptr(self)](const std::string& reason) {
    if (const auto dismissed = weak.lock())
      dismissed->End(Error(v1::ERROR_REASON_LEASE_LOST, reason));
  };
  OperatorLease::Answer answer;
  const auto asked = Guarded([&] { answer = host_.lease.RequestTicket(peer_, name, dismiss); });
  if (!asked.ok()) return asked;
  if (const auto* refusal = std::get_if<OperatorLease::Refusal>(&answer)) {
    host_.refused.Add("Operate", client_, refusal->why);
    return Error(v1::ERROR_REASON_LEASE_HELD, refusal->why);
  }
  ticket_ = std::get<OperatorLease::Ticket>(answer);
  host_.on_stream(context_, kCommandRate);
  host_.publisher.ServeFirst(self);
  return grpc::Status::OK;
}

OperateStream::OperateStream(const Host& host, const grpc::ServerContextBase& context)
    : host_(host), context_(context), peer_(context.peer()), client_(ClientOf(context)) {}

void OperateStream::Offer(const SlaveState& composed) {
  SlaveState state = composed;
  if (!wants_moment_) state.moment.reset();
  box_.Put(state);
  std::shared_ptr<DatagramLine> line;
  {
    const std::scoped_lock lock(mutex_);
    if (!ending_) line = line_;
  }
  if (line) {
    Write(state, &datagram_state_);
    datagram_state_.clear_events();
    ToProto(line->seen(), datagram_state_.mutable_datagrams_seen());
    line->Send(datagram_state_.SerializeAsString());
  }
  {
    const std::scoped_lock lock(mutex_);
    if (ending_ || writing_ || !MakeMessage()) return;
    writing_ = true;
    ++busy_;
  }
  StartWrite(&message_);
}

void OperateStream::OnReadDone(bool ok) {
  if (!ok) return End(grpc::Status::OK);  // the operator left
  TakeCommand(command_);
  if (command_.datagrams() && !std::exchange(datagrams_asked_, true)) OfferDatagrams();
  Read(&command_);
}

void OperateStream::TakeCommand(const v1::OperatorCommand& command) {
  wants_details_ = command.details();
  wants_moment_ = command.torque() || command.details();
  if (!host_.lease.Command(ticket_, command)) host_.publisher.Flag(Event::kCommandRefused);
}

void OperateStream::OnWriteDone(bool ok) {
  if (!ok) End(grpc::Status::CANCELLED);
  if (ok) ++host_.states_sent;
  bool more = false;
  {
    const std::scoped_lock lock(mutex_);
    more = !ending_ && MakeMessage();
    writing_ = more;
    if (line_) line_->StreamMoves();
  }
  if (more) {
    StartWrite(&message_);
  } else {
    Exit();
  }
}

void OperateStream::OnDone() {
  host_.lease.Release(ticket_);  // the lease may have been given while the stream ended
  EndingStream::OnDone();
}

void OperateStream::OnEnding() {
  std::shared_ptr<DatagramLine> last;
  {
    const std::scoped_lock lock(mutex_);
    last = std::move(line_);
  }
  last.reset();  // frees its port for the next operator
  host_.lease.Release(ticket_);
}

bool OperateStream::MakeMessage() {
  const auto newest = box_.TakeNewest();
  if (!newest) return false;
  Write(*newest, &message_);
  if (offer_) *message_.mutable_datagrams() = *std::exchange(offer_, std::nullopt);
  return true;
}

void OperateStream::Write(const SlaveState& state, v1::SlaveState* message) const {
  ToProto(state, message);
  if (wants_details_) ToProto(state.details, message->mutable_details());
}

void OperateStream::OfferDatagrams() {
  const auto ends = EndsOf(peer_);
  if (!ends) return;
  try {
    const DatagramLine::Keys keys{NewDatagramKey(), NewDatagramKey()};
    auto line = std::make_shared<DatagramLine>(
        DatagramLine::Role::kAnswers, ends->own, keys,
        [this](std::string_view decrypted) { return TakeDatagram(decrypted); });
    v1::DatagramOffer offer;
    offer.set_port(line->port());
    offer.set_command_key(keys.receive.data(), keys.receive.size());
    offer.set_state_key(keys.send.data(), keys.send.size());
    spdlog::info("datagrams for {} at port {}", peer_, line->port());
    const std::scoped_lock lock(mutex_);
    if (ending_) return;
    offer_ = offer;
    line_ = std::move(line);
  } catch (const std::exception& error) {
    spdlog::warn("no datagrams for {}: {}", peer_, error.what());
  }
}

// Processes a command like one of the stream. The lease decides which is newer.
DatagramLine::LinkFeedback OperateStream::TakeDatagram(std::string_view decrypted) {
  if (!datagram_command_.ParseFromArray(decrypted.data(), static_cast<int>(decrypted.size())))
    return {};
  TakeCommand(datagram_command_);
  DatagramLine::LinkFeedback feedback{.seen = FromProto(datagram_command_.datagrams_seen())};
  std::string reason;
  if (datagram_command_.has_echo()) {
    const Time sent_at = FieldReader(&reason).Stamp("echo", datagram_command_.echo());
    feedback.round_trip = SecondsBetween(sent_at, Clock::now());
  }
  return feedback;
}

}  // namespace palpate
