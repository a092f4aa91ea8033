#include "slave/service/feed_stream.h"

#include "slave/service/messages.h"

namespace palpate {
namespace {

using FeedReactor = grpc::ServerReadReactor<v1::TactileSample>;

constexpr std::size_t kMaxFingerName = 40;  // [bytes]; no finger of a scene has a longer one

}  // namespace

FeedStream::FeedStream(TactileInbox* inbox, v1::FeedTactileReply* reply)
    : inbox_(inbox), sender_(NewStreamId()), reply_(reply) {}

FeedReactor* FeedStream::Open(TactileInbox* inbox, FeedStreams* streams,
                              v1::FeedTactileReply* reply) {
  if (inbox == nullptr) {
    return new RefusedStream<FeedReactor>(
        Error(v1::ERROR_REASON_NOT_STREAMED,
              "the scene accepts no tactile samples: its sense.tactile.source is not stream"));
  }
  const std::shared_ptr<FeedStream> stream(new FeedStream(inbox, reply));
  stream->self_ = stream;
  if (!streams->Add(stream)) {
    stream->End(Stopping());
  } else {
    stream->Read(&stream->sample_);
  }
  return stream.get();
}

std::string FeedStream::Feed() {
  std::string reason;
  const auto sample = FromProto(sample_, &reason);
  const std::string name = sample_.finger().substr(0, kMaxFingerName);
  if (!sample) return "finger " + name + ": " + reason;
  const auto refusal = inbox_->Feed(sample_.finger(), sample_.sequence(), sample->sensed_at,
                                    sample->reading, Clock::now(), sender_, sample_.unit());
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
  } else {  // the driver has finished or was disconnected
    reply_->set_samples(samples_);
  }
  Exit();
  if (!ok) return End(grpc::Status::OK);
  if (!reason.empty()) return End(Error(v1::ERROR_REASON_INVALID_FIELD, reason));
  Read(&sample_);
}

// Permits the driver to start again without a pause.
void FeedStream::OnQuiet() {
  for (const std::string& finger : fingers_) inbox_->Leave(finger, sender_);
}

}  // namespace palpate
