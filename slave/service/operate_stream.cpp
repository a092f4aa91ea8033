#include "slave/service/operate_stream.h"

#include <variant>

#include <spdlog/spdlog.h>

#include "shared/link/tcp_line.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

using Reactor = grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>;

}  // namespace

Reactor* OperateStream::Open(const Host& host, const std::string& peer) {
  const std::shared_ptr<OperateStream> stream(new OperateStream(host, peer));
  const auto dismiss = [weak = std::weak_ptr(stream)](const std::string& reason) {
    if (const auto dismissed = weak.lock()) dismissed->End({grpc::StatusCode::ABORTED, reason});
  };
  std::variant<OperatorLease::Ticket, OperatorLease::HeldBy> answer;
  const grpc::Status asked = Guarded([&] { answer = host.lease.RequestTicket(peer, dismiss); });
  if (!asked.ok()) return new RefusedStream<Reactor>(asked);
  if (const auto* held = std::get_if<OperatorLease::HeldBy>(&answer)) {
    return new RefusedStream<Reactor>(
        {grpc::StatusCode::FAILED_PRECONDITION,
         "the lease is held by " + held->who + ": it becomes free when that stream ends"});
  }
  stream->self_ = stream;
  stream->ticket_ = std::get<OperatorLease::Ticket>(answer);
  stream->ReadNext();
  host.publisher.ServeFirst(stream);
  return stream.get();
}

void OperateStream::Offer(const SlaveState& state) {
  box_.Put(state);
  std::shared_ptr<DatagramLine> line;
  {
    const std::scoped_lock lock(mutex_);
    if (!ending_) line = line_;
  }
  if (line) {
    ToProto(state, &datagram_state_);
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
  if (!host_.lease.Command(ticket_, command_)) host_.publisher.Flag(Event::kCommandRefused);
  if (command_.datagrams() && !std::exchange(datagrams_asked_, true)) OfferDatagrams();
  ReadNext();
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

void OperateStream::OnEnding() {
  std::shared_ptr<DatagramLine> last;
  {
    const std::scoped_lock lock(mutex_);
    last = std::move(line_);
  }
  last.reset();  // its port is free for the next operator
  host_.lease.Release(ticket_);
}

bool OperateStream::MakeMessage() {
  const auto newest = box_.TakeNewest();
  if (!newest) return false;
  ToProto(*newest, &message_);
  if (offer_) *message_.mutable_datagrams() = *std::exchange(offer_, std::nullopt);
  return true;
}

void OperateStream::OfferDatagrams() {
  const auto ends = EndsOf(peer_);
  if (!ends) return;
  try {
    const DatagramLine::Keys keys{NewDatagramKey(), NewDatagramKey()};
    auto line = std::make_shared<DatagramLine>(
        DatagramLine::Role::kAnswers, ends->own, keys,
        [this](std::string_view plain) { return TakeDatagram(plain); });
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

// As one that came by the stream, where the lease looks at what is newer.
DatagramLine::LinkFeedback OperateStream::TakeDatagram(std::string_view plain) {
  if (!datagram_command_.ParseFromArray(plain.data(), static_cast<int>(plain.size()))) return {};
  if (!host_.lease.Command(ticket_, datagram_command_)) {
    host_.publisher.Flag(Event::kCommandRefused);
  }
  DatagramLine::LinkFeedback told{.seen = FromProto(datagram_command_.datagrams_seen())};
  std::string reason;
  if (datagram_command_.has_echo()) {
    const Time sent_at = FieldReader(&reason).Stamp("echo", datagram_command_.echo());
    told.round_trip = SecondsBetween(sent_at, Clock::now());
  }
  return told;
}

void OperateStream::ReadNext() {
  if (!Enter()) return;
  StartRead(&command_);
  Exit();
}

}  // namespace palpate
