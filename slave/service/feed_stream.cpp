#include "slave/service/feed_stream.h"

#include <atomic>
#include <utility>

#include "slave/service/status.h"
#include "slave/service/tactile_sample.h"

namespace palpate {
namespace {

using Reactor = grpc::ServerReadReactor<v1::TactileSample>;

constexpr std::size_t kLongestName = 40;  // [bytes]; no finger of a scene has a longer one

// A stream that ends before it began.
class RefusedFeed final : public Reactor {
 public:
  explicit RefusedFeed(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

TactileInbox::SenderId NewSender() {
  static std::atomic<TactileInbox::SenderId> last{TactileInbox::kOnlySender};
  return ++last;
}

}  // namespace

FeedStream::FeedStream(TactileInbox* inbox, v1::FeedTactileReply* reply)
    : inbox_(inbox), sender_(NewSender()), reply_(reply) {}

Reactor* FeedStream::Open(TactileInbox* inbox, FeedStreams* streams, v1::FeedTactileReply* reply) {
  if (inbox == nullptr) {
    return new RefusedFeed({grpc::StatusCode::FAILED_PRECONDITION,
                            "the scene takes no tactile samples: its sense.tactile.source is no "
                            "stream"});
  }
  const std::shared_ptr<FeedStream> stream(new FeedStream(inbox, reply));
  stream->self_ = stream;
  if (!streams->Add(stream)) {
    stream->End(Stopping());
  } else {
    stream->ReadNext();
  }
  return stream.get();
}

void FeedStream::Close() {
  End(Stopping());
}

std::string FeedStream::Feed() {
  std::string reason;
  const auto sample = FromProto(sample_, &reason);
  const std::string name = sample_.finger().substr(0, kLongestName);
  if (!sample) return "finger " + name + ": " + reason;
  const auto refusal = inbox_->Feed(sample_.finger(), sample_.sequence(), sample->sensed_at,
                                    sample->reading, Clock::now(), sender_);
  if (refusal) return "finger " + name + " " + refusal->why;
  fingers_.insert(sample_.finger());
  ++samples_;
  return {};
}

void FeedStream::OnReadDone(bool ok) {
  if (!Enter()) return;
  std::string reason;
  if (ok) {
    reason = Feed();
  } else {  // the driver has sent all, or is gone
    reply_->set_samples(samples_);
  }
  Exit();
  if (!ok) return End(grpc::Status::OK);
  if (!reason.empty()) return End({grpc::StatusCode::INVALID_ARGUMENT, reason});
  ReadNext();
}

void FeedStream::OnCancel() {
  End(grpc::Status::CANCELLED);
}

void FeedStream::OnDone() {
  const auto last = std::move(self_);
}

void FeedStream::ReadNext() {
  if (!Enter()) return;
  StartRead(&sample_);
  Exit();
}

bool FeedStream::Enter() {
  const std::scoped_lock lock(mutex_);
  if (ending_) return false;
  ++busy_;
  return true;
}

void FeedStream::Exit() {
  {
    const std::scoped_lock lock(mutex_);
    --busy_;
  }
  FinishIfQuiet();
}

void FeedStream::End(const grpc::Status& status) {
  {
    const std::scoped_lock lock(mutex_);
    if (!ending_) ending_ = status;
  }
  FinishIfQuiet();
}

void FeedStream::FinishIfQuiet() {
  grpc::Status status;
  {
    const std::scoped_lock lock(mutex_);
    if (!ending_ || busy_ > 0 || finished_) return;
    finished_ = true;
    status = *ending_;
  }
  // Before the driver hears that its stream is over: it may start anew at once.
  for (const std::string& finger : fingers_) inbox_->Leave(finger, sender_);
  Finish(status);
}

bool FeedStreams::Add(const std::shared_ptr<FeedStream>& stream) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(streams_, [](const auto& other) { return other.expired(); });
  if (!closed_) streams_.push_back(stream);
  return !closed_;
}

void FeedStreams::Close() {
  std::vector<std::weak_ptr<FeedStream>> streams;
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    streams.swap(streams_);
  }
  for (const auto& weak : streams) {
    if (const auto stream = weak.lock()) stream->Close();
  }
}

}  // namespace palpate
