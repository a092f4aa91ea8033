#include "slave/service/operate_stream.h"

#include <variant>

#include "shared/link/thread_priority.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

using Reactor = grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>;

}  // namespace

Reactor* OperateStream::Open(const Host& host, const std::string& peer) {
  const std::shared_ptr<OperateStream> stream(new OperateStream(host));
  const auto dismiss = [weak = std::weak_ptr(stream)](const std::string& reason) {
    if (const auto dismissed = weak.lock()) dismissed->End({grpc::StatusCode::ABORTED, reason});
  };
  std::variant<OperatorLease::Ticket, OperatorLease::HeldBy> answer;
  const grpc::Status asked = Guarded([&] { answer = host.lease.Ask(peer, dismiss); });
  if (!asked.ok()) return new RefusedStream<Reactor>(asked);
  if (const auto* held = std::get_if<OperatorLease::HeldBy>(&answer)) {
    return new RefusedStream<Reactor>(
        {grpc::StatusCode::FAILED_PRECONDITION,
         "the lease is held by " + held->who + ": it is free when that stream ends"});
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
    ++busy_;
  }
  StartWrite(&message_);
}

void OperateStream::OnReadDone(bool ok) {
  // The thread that reads the operator's words must not wait behind whatever else runs.
  thread_local const std::string refused = MakeThreadRealtime(kReadingPriority);
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
    Exit();
  }
}

void OperateStream::ReadNext() {
  if (!Enter()) return;
  StartRead(&command_);
  Exit();
}

}  // namespace palpate
