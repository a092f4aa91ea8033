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

constexpr double kMilli = 1e-3;

}  // namespace

grpc::Status OperateSession::Run(const std::stop_token& stop) {
  received_at_ = Clock::now() + first_within_;
  const auto stream = with_.stub.Operate(&context_);
  std::jthread sender([&](const std::stop_token& ended) {
    std::stop_source either;
    const std::stop_callback on_stop(stop, [&] { either.request_stop(); });
    const std::stop_callback on_end(ended, [&] { either.request_stop(); });
    SendCommands(stream.get(), either.get_token());
  });
  auto message = std::make_shared<v1::SlaveState>();
  bool is_first = true;
  while (stream->Read(message.get())) {
    if (std::exchange(is_first, false)) {
      if (const auto expiry = ExpiryOf(*context_.auth_context())) trusted_until_ = *expiry;
    }
    ReceiveFromStream(std::exchange(message, std::make_shared<v1::SlaveState>()));
  }
  exchange_.End();
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
  MakeThreadRealtime(kReadingPriority);
  for (auto wake = Clock::now(); !stop.stop_requested(); wake += kCommandPeriod) {
    std::this_thread::sleep_until(Clock::ToSteady(wake));
    const Time now = Clock::now();
    if (now - wake > kCommandPeriod) wake = now;  // skip missed periods
    if (!MayGoOn(now)) break;
    SendNewest(stream);
  }
  writer_.reset();  // its thread uses the stream and the datagram socket
  stream->WritesDone();
}

bool OperateSession::MayGoOn(Time now) {
  silent_ = now - received_at_.load() > silence_;
  expired_ = std::chrono::system_clock::now() >= trusted_until_.load();
  if (!silent_ && !expired_) return true;
  context_.TryCancel();
  return false;
}

void OperateSession::SendNewest(Stream* stream) {
  const std::optional<OperatorCommand> command = exchange_.NextCommand(Clock::now());
  if (!command) return;
  ToProto(*command, &message_);
  if (!std::exchange(is_introduced_, true)) {
    message_.set_operator_name(operator_name_);
    message_.set_datagrams(requests_.datagrams);
  }
  message_.set_details(requests_.details);
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
  if (with_.on_sent) with_.on_sent(*command);
}

// The keys of the datagrams belong to this stream: they are neither recorded nor shown.
void OperateSession::ReceiveFromStream(std::shared_ptr<v1::SlaveState> message) {
  const Time now = Clock::now();
  if (message->has_datagrams()) OpenDatagrams(message->datagrams());
  message->clear_datagrams();
  if (exchange_.TakeFromStream(std::move(message), now)) {
    received_at_ = now;  // only the stream counts, not datagrams
  }
}

DatagramLine::LinkFeedback OperateSession::ReceiveDatagram(std::string_view plain) {
  const Time now = Clock::now();
  const auto message = std::make_shared<v1::SlaveState>();
  if (!message->ParseFromArray(plain.data(), static_cast<int>(plain.size()))) return {};
  const auto seen = FromProto(message->datagrams_seen());
  message->clear_datagrams();
  if (!exchange_.TakeDatagram(message, now)) return {};
  with_.datagram_at = now;
  return {seen, with_.exchange.trips.newest()};
}

// Uses only the address of the stream, so that a slave cannot make the master flood another
// machine. If this fails, the stream continues alone.
void OperateSession::OpenDatagrams(const v1::DatagramOffer& offer) {
  const auto to_send = DatagramKeyFrom(offer.command_key());
  const auto to_receive = DatagramKeyFrom(offer.state_key());
  const auto ends = EndsOf(context_.peer());
  const bool is_port = offer.port() >= 1 && offer.port() <= std::numeric_limits<in_port_t>::max();
  if (!requests_.datagrams || line_ || !to_send || !to_receive || !ends || !is_port) return;
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

}  // namespace palpate
