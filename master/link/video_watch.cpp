#include "master/link/video_watch.h"

#include "master/link/stream_keeper.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr std::size_t kLargestJpeg = 16 << 20;  // [bytes]

v1::WatchVideoRequest Request(const VideoWatch::Options& options) {
  v1::WatchVideoRequest request;
  request.set_max_rate_hz(options.rate);
  request.set_overlays(true);
  request.set_quality(static_cast<std::uint32_t>(options.quality));
  return request;
}

}  // namespace

struct VideoWatch::Parts {
  Parts(const SlaveLink::Options& link, const Options& options)
      : request(Request(options)), stub(BulkStub(link)) {}

  // What is no picture, or of no known instant, is left out.
  std::string Take(const v1::VideoFrame& frame) {
    std::string reason;
    FieldReader reader(&reason);
    const Time sensed_at = reader.Stamp("sensed_at", frame.sensed_at());
    if (!reader.ok() || frame.jpeg().empty() || frame.jpeg().size() > kLargestJpeg) return {};
    const std::scoped_lock lock(mutex);
    newest = std::make_shared<const RemotePicture>(
        RemotePicture{newest ? newest->number + 1 : 1, sensed_at, static_cast<int>(frame.width()),
                      static_cast<int>(frame.height()), frame.jpeg()});
    return {};
  }

  const v1::WatchVideoRequest request;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  mutable std::mutex mutex;  // guards what follows
  std::shared_ptr<const RemotePicture> newest;
  StreamKeeper<v1::VideoFrame> keeper{
      [this](grpc::ClientContext* context) { return stub->WatchVideo(context, request); },
      [this](v1::VideoFrame* frame) { return Take(*frame); }};  // last: it uses all of the above
};

VideoWatch::VideoWatch(const SlaveLink::Options& link, const Options& options)
    : parts_(std::make_unique<Parts>(link, options)) {}

VideoWatch::~VideoWatch() = default;

std::shared_ptr<const RemotePicture> VideoWatch::newest() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->newest;
}

std::string VideoWatch::trouble() const {
  return parts_->keeper.stats().trouble;
}

}  // namespace palpate
