#include "slave/service/feed_stream.h"

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

}  // namespace

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
                                    sample->reading, Clock::now());
  if (refusal) return "finger " + name + " " + refusal->why;
  fingers_.insert(sample_.finger());
  ++samples_;
  return {};
}

void FeedStream::OnReadDone(bool ok) {
  if (!ok) {  // the driver has sent all, or is gone
    reply_->set_samples(samples_);
    return End(grpc::Status::OK);
  }
  if (const std::string reason = Feed(); !reason.empty()) {
    return End({grpc::StatusCode::INVALID_ARGUMENT, reason});
  }
  ReadNext();
}

void FeedStream::OnCancel() {
  End(grpc::Status::CANCELLED);
}

void FeedStream::OnDone() {
  for (const std::string& finger : fingers_) inbox_->Leave(finger);
  const auto last = std::move(self_);
}

void FeedStream::ReadNext() {
  {
    const std::scoped_lock lock(mutex_);
    if (ending_) return;
    ++arming_reads_;
  }
  StartRead(&sample_);
  {
    const std::scoped_lock lock(mutex_);
    --arming_reads_;
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
    if (!ending_ || arming_reads_ > 0 || finished_) return;
    finished_ = true;
    status = *ending_;
  }
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
