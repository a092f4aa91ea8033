#include "slave/capture/shared_camera.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/scene/units.h"

namespace palpate {
namespace {

bool IsLive(const Camera& camera) {
  return camera.source == Camera::Source::kDevice || camera.source == Camera::Source::kUrl;
}

// Repeats recorded images endlessly.
class RepeatedFrames final : public FrameSource {
 public:
  RepeatedFrames(const Camera& camera, ImageFilter filter)
      : camera_(camera), filter_(std::move(filter)), source_(Reopened()) {}

  std::optional<Frame> Next(const std::stop_token& stop) override {
    std::optional<Frame> frame = source_->Next(stop);
    if (!frame && !stop.stop_requested()) {
      source_ = Reopened();
      frame = source_->Next(stop);
    }
    if (frame) frame->sequence = ++sequence_;
    return frame;
  }
  [[nodiscard]] std::string description() const override { return source_->description(); }

 private:
  [[nodiscard]] std::unique_ptr<FrameSource> Reopened() const {
    return OpenCamera(camera_, filter_);
  }

  const Camera camera_;
  const ImageFilter filter_;
  std::unique_ptr<FrameSource> source_;
  std::uint64_t sequence_ = 0;
};

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

// A thread reads the live camera; every reader gets the newest image.
class SharedCamera::Live {
 public:
  explicit Live(std::unique_ptr<FrameSource> source)
      : source_(std::move(source)), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // Returns the newest image after number `last`; nullopt: `stop` was requested or the camera has
  // ended.
  std::optional<Frame> After(std::uint64_t last, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return has_ended_ || newest_.sequence > last; });
    if (stop.stop_requested()) return std::nullopt;
    if (newest_.sequence > last) return newest_;
    if (failure_) std::rethrow_exception(failure_);
    return std::nullopt;
  }
  // Returns the first image taken after this call; nullopt: `stop` was requested. Throws
  // std::runtime_error if none arrives within `timeout` [s].
  std::optional<Frame> Fresh(double timeout, const std::stop_token& stop) {
    const Time asked = Clock::now();
    std::unique_lock lock(mutex_);
    const auto is_here = [&] { return newest_.sequence > 0 && newest_.sensed_at > asked; };
    changed_.wait_until(lock, stop, std::chrono::steady_clock::now() + Seconds(timeout),
                        [&] { return has_ended_ || is_here(); });
    if (stop.stop_requested()) return std::nullopt;
    if (is_here()) return newest_;
    if (failure_) std::rethrow_exception(failure_);
    const auto health = source_->health();
    throw std::runtime_error(
        fmt::format("{}: no new image within {:.3g} s{}", source_->description(), timeout,
                    health && !health->trouble.empty() ? ": " + health->trouble : std::string()));
  }
  [[nodiscard]] const FrameSource& source() const { return *source_; }

 private:
  void Run(const std::stop_token& stop) {
    std::exception_ptr failure;
    try {
      while (auto frame = source_->Next(stop)) {
        {
          const std::lock_guard lock(mutex_);
          newest_ = *std::move(frame);
        }
        changed_.notify_all();
      }
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      has_ended_ = true;
      failure_ = failure;
    }
    changed_.notify_all();
  }

  const std::unique_ptr<FrameSource> source_;
  PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition changed_;
  Frame newest_;
  bool has_ended_ = false;
  std::exception_ptr failure_;
  std::jthread thread_;  // last: it uses all of the above
};

// LiveFrames is one reader of a live camera.
class SharedCamera::LiveFrames final : public FrameSource {
 public:
  LiveFrames(std::shared_ptr<Live> live, ImageFilter filter, std::optional<Frame> first)
      : live_(std::move(live)), filter_(std::move(filter)), first_(std::move(first)) {}

  std::optional<Frame> Next(const std::stop_token& stop) override {
    std::optional<Frame> frame = std::exchange(first_, std::nullopt);
    if (!frame) frame = live_->After(last_, stop);
    if (!frame) return frame;
    last_ = frame->sequence;
    if (filter_) frame->image = filter_(frame->image);
    return frame;
  }
  [[nodiscard]] std::string description() const override { return live_->source().description(); }
  [[nodiscard]] std::optional<CameraHealth> health() const override {
    return live_->source().health();
  }

 private:
  const std::shared_ptr<Live> live_;
  const ImageFilter filter_;
  std::optional<Frame> first_;
  std::uint64_t last_ = 0;
};

SharedCamera::SharedCamera(const Camera& camera) : camera_(camera) {
  if (IsLive(camera_)) live_ = std::make_shared<Live>(OpenCamera(camera_));
  const std::optional<Frame> first = Open()->Next({});
  if (!first) throw std::runtime_error("--camera: no image received");
  camera_.size = {first->image.cols, first->image.rows};
}

SharedCamera::~SharedCamera() = default;

std::unique_ptr<FrameSource> SharedCamera::Open(const ImageFilter& filter,
                                                std::optional<Frame> first) const {
  if (live_) return std::make_unique<LiveFrames>(live_, filter, std::move(first));
  return std::make_unique<RepeatedFrames>(camera_, filter);
}

std::optional<Frame> SharedCamera::Fresh(const std::stop_token& stop) const {
  constexpr double kTimeout = 2;  // [s]
  if (!live_) return Open()->Next(stop);
  return live_->Fresh(std::max(kTimeout, 2 / camera_.rate), stop);
}

std::string SharedCamera::SceneLines() const {
  std::string source = "file: " + Quoted(camera_.pattern);
  if (camera_.source == Camera::Source::kDevice) source = fmt::format("device: {}", camera_.device);
  if (camera_.source == Camera::Source::kUrl) source = "url: " + Quoted(camera_.pattern);
  return fmt::format("{}\nrate: {:g} Hz\nsize: [{}, {}]\n", source, camera_.rate, camera_.size[0],
                     camera_.size[1]);
}

bool SharedCamera::IsOpenedBy(const Camera& other) const {
  return other.source == camera_.source && other.pattern == camera_.pattern &&
         other.device == camera_.device && other.rate == camera_.rate && other.size == camera_.size;
}

Camera NamedCamera(const std::string& name, double rate) {
  Camera camera;
  camera.rate = rate;
  if (const auto number = ParseInteger(name); number && *number >= 0) {
    camera.source = Camera::Source::kDevice;
    camera.device = static_cast<int>(*number);
    return camera;
  }
  camera.size = {0, 0};
  camera.pattern = name;
  camera.source = Camera::Source::kUrl;
  if (name.find("://") != std::string::npos || name.find('!') != std::string::npos) return camera;
  camera.pattern = std::filesystem::absolute(name).lexically_normal().string();
  camera.source = IsVideo(camera.pattern) ? Camera::Source::kVideo : Camera::Source::kFiles;
  return camera;
}

}  // namespace palpate
