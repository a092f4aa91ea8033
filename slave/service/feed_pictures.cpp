// FeedPictures. Decoding takes milliseconds: in the call's own thread, which also slows a driver
// down who sends more than can be looked at.
#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "slave/service/messages.h"
#include "slave/service/status.h"
#include "slave/service/stream_list.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr double kPictureRate = 64e6;  // [bytes/s]

// Leaves with the stream.
class Sender {
 public:
  explicit Sender(PictureInbox* inbox) : inbox_(inbox), id_(NewStreamId()) {}
  ~Sender() { inbox_->Leave(id_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  grpc::Status Feed(const v1::PictureSample& message) {
    const Time now = Clock::now();
    std::string reason;
    const auto sample = FromProto(message, &reason);
    if (!sample) return {grpc::StatusCode::INVALID_ARGUMENT, reason};
    const auto refusal = inbox_->Feed(*sample, now, id_);
    if (!refusal) return grpc::Status::OK;
    const auto code = refusal->is_held ? grpc::StatusCode::FAILED_PRECONDITION
                                       : grpc::StatusCode::INVALID_ARGUMENT;
    return {code, "sample " + std::to_string(message.sequence()) + ": " + refusal->why};
  }

 private:
  PictureInbox* inbox_;
  PictureInbox::SenderId id_;
};

}  // namespace

grpc::Status TeleoperationService::FeedPictures(grpc::ServerContext* context,
                                                grpc::ServerReader<v1::PictureSample>* reader,
                                                v1::FeedPicturesReply* reply) {
  const OrdinaryPriority ordinary;
  PictureInbox* const inbox = slave_.picture_inbox();
  on_stream_(*context, inbox != nullptr ? kPictureRate : 0);
  if (inbox == nullptr) {
    return {grpc::StatusCode::FAILED_PRECONDITION,
            "the scene accepts no images: the source of its sense.camera is not stream"};
  }
  const Seats::Seat seat(&picture_feeds_);
  if (!seat) {
    return {grpc::StatusCode::FAILED_PRECONDITION, "images are fed by " +
                                                       std::to_string(picture_feeds_.count()) +
                                                       " streams: accepted is one"};
  }
  Sender sender(inbox);
  const std::uint64_t dropped = inbox->health().dropped;
  std::uint64_t samples = 0;
  v1::PictureSample message;
  while (reader->Read(&message)) {
    if (const grpc::Status taken = sender.Feed(message); !taken.ok()) return taken;
    ++samples;
  }
  reply->set_samples(samples);
  reply->set_dropped(inbox->health().dropped - dropped);
  return grpc::Status::OK;
}

}  // namespace palpate
