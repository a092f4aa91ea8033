#include "slave/service/operate_stream.h"

#include <utility>
#include <variant>

#include "shared/wire/state_message.h"
#include "slave/service/status.h"

namespace palpate {
namespace {

using Reactor = grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>;

// A stream that ends before it began.
class Refusal final : public Reactor {
 public:
  explicit Refusal(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

Reactor* OperateStream::Open(const Host& host, const std::string& peer) {
  const std::shared_ptr<OperateStream> stream(new OperateStream(host));
  const auto dismiss = [weak = std::weak_ptr(stream)](const std::string& reason) {
    if (const auto dismissed = weak.lock()) dismissed->End({grpc::StatusCode::ABORTED, reason});
  };
  std::variant<OperatorLease::Ticket, OperatorLease::HeldBy> answer;
  const grpc::Status asked = Guarded([&] { answer = host.lease.Ask(peer, dismiss); });
  if (!asked.ok()) return new Refusal(asked);
  if (const auto* held = std::get_if<OperatorLease::HeldBy>(&answer)) {
    return new Refusal({grpc::StatusCode::FAILED_PRECONDITION, "the lease is held by " + held->who +
                                                                   ": it is free when that "
                                                                   "stream ends"});
  }
  stream->self_ = stream;
  stream->ticket_ = std::get<OperatorLease::Ticket>(answer);
  stream->ReadNext();
  host.publisher.ServeFirst(stream);
  return stream.get();
}

void OperateStream::Offer(const SlaveState& state) {
  box_.Put(state);
  {
    const std::scoped_lock lock(mutex_);
    if (ending_ || writing_) return;
    const auto newest = box_.TakeNewest();
    if (!newest) return;
    ToProto(*newest, &message_);
    writing_ = true;
  }
  StartWrite(&message_);
}

void OperateStream::Close() {
  End(Stopping());
}

void OperateStream::OnReadDone(bool ok) {
  if (!ok) return End(grpc::Status::OK);  // the operator left
  if (!host_.lease.Command(ticket_, command_)) host_.publisher.Flag(Event::kCommandRefused);
  ReadNext();
}

void OperateStream::OnWriteDone(bool ok) {
  if (!ok) End(grpc::Status::CANCELLED);
  if (ok) ++host_.states_sent;
  bool more = false;
  {
    const std::scoped_lock lock(mutex_);
    const auto newest = box_.TakeNewest();
    more = newest && !ending_;
    if (more) ToProto(*newest, &message_);
    writing_ = more;
  }
  if (more) {
    StartWrite(&message_);
  } else {
    FinishIfQuiet();
  }
}

void OperateStream::OnCancel() {
  End(grpc::Status::CANCELLED);
}

void OperateStream::OnDone() {
  const auto last = std::move(self_);  // the publisher may hold another
}

void OperateStream::ReadNext() {
  {
    const std::scoped_lock lock(mutex_);
    if (ending_) return;
    ++arming_reads_;
  }
  StartRead(&command_);
  {
    const std::scoped_lock lock(mutex_);
    --arming_reads_;
  }
  FinishIfQuiet();
}

void OperateStream::End(const grpc::Status& status) {
  host_.lease.Release(ticket_);
  {
    const std::scoped_lock lock(mutex_);
    if (!ending_) ending_ = status;
  }
  FinishIfQuiet();
}

void OperateStream::FinishIfQuiet() {
  grpc::Status status;
  {
    const std::scoped_lock lock(mutex_);
    if (!ending_ || writing_ || arming_reads_ > 0 || finished_) return;
    finished_ = true;
    status = *ending_;
  }
  Finish(status);
}

}  // namespace palpate
