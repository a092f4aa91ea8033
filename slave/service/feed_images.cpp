// FeedImages. Decoding takes milliseconds. It is done in the thread of the call, which also slows
// down a driver that sends more than can be processed. Only decoding has ordinary priority: a
// thread that waits in gRPC may be the one that reads for all connections, and holds their locks.
#include <memory>
#include <string>

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "slave/service/messages.h"
#include "slave/service/status.h"
#include "slave/service/stream_list.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr double kImageRate = 64e6;  // [bytes/s]

}  // namespace

grpc::Status TeleoperationService::FeedImages(grpc::ServerContext* context,
                                              grpc::ServerReader<v1::ImageSample>* reader,
                                              v1::FeedImagesReply* reply) {
  ImageInbox* const inbox = slave_.image_inbox();
  if (inbox == nullptr) {
    return Error(v1::ERROR_REASON_NOT_STREAMED,
                 "the scene accepts no images: the source of its sense.camera is not stream");
  }
  const Seats::Seat seat(&image_feeds_);
  if (!seat) {
    return Error(
        v1::ERROR_REASON_SOURCE_TAKEN,
        "images are fed by " + std::to_string(image_feeds_.count()) + " streams: expected one");
  }
  on_stream_(*context, kImageRate);
  const auto id = NewStreamId();
  const std::shared_ptr<void> leaves(nullptr, [&](void*) { inbox->Leave(id); });
  const std::uint64_t dropped = inbox->health().dropped;
  std::uint64_t samples = 0;
  v1::ImageSample message;
  while (reader->Read(&message)) {
    const OrdinaryPriority ordinary;
    const Time now = Clock::now();
    std::string reason;
    const auto sample = FromProto(message, &reason);
    if (!sample) return Error(v1::ERROR_REASON_INVALID_FIELD, reason);
    if (const auto refusal = inbox->Feed(*sample, now, id)) {
      return Error(
          refusal->is_held ? v1::ERROR_REASON_SOURCE_TAKEN : v1::ERROR_REASON_INVALID_FIELD,
          "sample " + std::to_string(message.sequence()) + ": " + refusal->why);
    }
    ++samples;
  }
  reply->set_samples(samples);
  reply->set_dropped(inbox->health().dropped - dropped);
  return grpc::Status::OK;
}

}  // namespace palpate
