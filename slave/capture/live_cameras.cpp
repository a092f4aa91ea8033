#include "slave/capture/live_cameras.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/capture/image_queue.h"

namespace palpate {
namespace {

std::chrono::steady_clock::time_point After(std::chrono::milliseconds duration) {
  return std::chrono::steady_clock::now() + duration;
}

constexpr std::size_t kMaxWaiting = 4;  // images per camera that may still find their partner
constexpr auto kRetry = std::chrono::milliseconds(250);    // before a lost camera is opened again
constexpr auto kThreadEndTime = std::chrono::seconds(3);   // limit for a thread that must end
constexpr auto kStreamOpenTime = std::chrono::seconds(5);  // limit for opening a stream
constexpr double kMaxTimeWithoutPair = 1;                  // longer is reported [s]

// Returns an empty image at the end of the stream. An exception of the library counts as a lost
// camera.
cv::Mat NextOf(VideoStream* video) {
  try {
    return video != nullptr ? video->Next() : cv::Mat();
  } catch (const std::exception&) {
    return {};
  }
}

std::string InWords(const cv::Mat& image) {
  return fmt::format("{} x {} px, {}", image.cols, image.rows, TypeInWords(image.type()));
}

struct ReceivedImage {
  cv::Mat image;
  Time at{};
};

// LiveCamera is the state of one camera, written by its thread.
struct LiveCamera {
  enum class Stage : std::uint8_t { kOpening, kOpened, kEnded } stage = Stage::kOpening;
  std::exception_ptr refusal;  // error of the first opening
  bool gone = false;
  std::deque<ReceivedImage> waiting;  // images that wait for their partners
  cv::Mat first;                      // first image; all must have its format
  std::string unlike;                 // why the newest image is refused; empty: it is accepted
};

}  // namespace

struct LiveCameras::State {
  State(std::vector<CameraInput> of, double max_apart, std::chrono::milliseconds longest)
      : inputs(std::move(of)), sync(max_apart), timeout(longest), cameras(inputs.size()) {}

  // Runs on a camera's thread. Opening and reading are calls of another library, which may never
  // return.
  void Run(std::size_t i, const std::stop_token& stop);
  void ReadOpened(std::size_t i, std::unique_ptr<VideoStream> video, const std::stop_token& stop);
  void Reach(std::size_t i, LiveCamera::Stage stage);
  // Throws std::runtime_error if the camera is missing or does not answer.
  void AwaitOpened(std::size_t i);
  [[nodiscard]] bool HasEnded(std::size_t i);  // waits for a limited time
  void Put(std::size_t i, cv::Mat image, Time at);
  void SetGone(std::size_t i, bool is_gone);
  // Call this function and those below with the mutex locked. Returns whether the image has the
  // format of the camera's first image.
  bool IsLikeFirst(std::size_t i, const cv::Mat& image);
  // Finds the newest images that form a pair.
  void Match();
  void Hand(StereoPair images);
  [[nodiscard]] std::string Trouble(Time now) const;
  // Throws std::runtime_error if the image is not accepted, or none arrives.
  void AwaitFirst(const std::stop_token& stop);

  const std::vector<CameraInput> inputs;
  const double sync;
  const std::chrono::milliseconds timeout;
  ImageQueue queue;

  mutable PriorityInheritanceMutex mutex;  // guards the members below
  PriorityInheritanceCondition changed;
  std::vector<LiveCamera> cameras;
  CameraHealth health;
  double apart = 0;  // time between the images of the last dropped pair [s]
  Time matched_at = Clock::now();
};

void LiveCameras::State::Run(std::size_t i, const std::stop_token& stop) {
  try {
    std::unique_ptr<VideoStream> video = inputs[i].open();
    if (!video) {
      throw std::runtime_error(inputs[i].name +
                               ": no such camera or stream, no permission, or no answer");
    }
    Reach(i, LiveCamera::Stage::kOpened);
    ReadOpened(i, std::move(video), stop);
  } catch (const std::exception&) {
    const std::lock_guard lock(mutex);
    cameras[i].refusal = std::current_exception();
  }
  Reach(i, LiveCamera::Stage::kEnded);
}

void LiveCameras::State::Reach(std::size_t i, LiveCamera::Stage stage) {
  {
    const std::lock_guard lock(mutex);
    cameras[i].stage = stage;
  }
  changed.notify_all();
}

void LiveCameras::State::AwaitOpened(std::size_t i) {
  std::unique_lock lock(mutex);
  const LiveCamera& camera = cameras[i];
  const auto answered = [&] { return camera.stage != LiveCamera::Stage::kOpening; };
  if (!changed.wait_until(lock, After(timeout), answered)) {
    throw std::runtime_error(fmt::format("{}: no answer within {:g} s", inputs[i].name,
                                         std::chrono::duration<double>(timeout).count()));
  }
  if (camera.refusal) std::rethrow_exception(camera.refusal);
}

bool LiveCameras::State::HasEnded(std::size_t i) {
  std::unique_lock lock(mutex);
  return changed.wait_until(lock, After(kThreadEndTime),
                            [&] { return cameras[i].stage == LiveCamera::Stage::kEnded; });
}

void LiveCameras::State::ReadOpened(std::size_t i, std::unique_ptr<VideoStream> video,
                                    const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    cv::Mat image = NextOf(video.get());
    if (!image.empty()) {
      Put(i, std::move(image), Clock::now());
      continue;
    }
    video.reset();  // before it is opened again
    SetGone(i, true);
    {
      std::unique_lock lock(mutex);
      changed.wait_until(lock, stop, After(kRetry), [] { return false; });
    }
    if (stop.stop_requested()) return;
    try {
      video = inputs[i].open();
    } catch (const std::exception&) {  // the camera is still missing
    }
    if (video) SetGone(i, false);
  }
}

void LiveCameras::State::SetGone(std::size_t i, bool is_gone) {
  const std::lock_guard lock(mutex);
  cameras[i].gone = is_gone;
  if (is_gone) cameras[i].waiting.clear();
}

void LiveCameras::State::Put(std::size_t i, cv::Mat image, Time at) {
  {
    const std::lock_guard lock(mutex);
    if (IsLikeFirst(i, image)) {
      auto& waiting = cameras[i].waiting;
      waiting.push_back({std::move(image), at});
      if (waiting.size() > kMaxWaiting) waiting.pop_front();
      Match();
    }
  }
  changed.notify_all();
}

bool LiveCameras::State::IsLikeFirst(std::size_t i, const cv::Mat& image) {
  const CameraInput& input = inputs[i];
  LiveCamera& camera = cameras[i];
  camera.unlike.clear();
  if (camera.first.empty() && !input.size.empty() && image.size() != input.size) {
    camera.unlike =
        fmt::format("{}: {} x {} px: expected {} x {} px, the size in the scene or its rig",
                    input.name, image.cols, image.rows, input.size.width, input.size.height);
    return false;
  }
  if (camera.first.empty()) camera.first = image;
  if (image.size() == camera.first.size() && image.type() == camera.first.type()) return true;
  camera.unlike = fmt::format("{}: {}: expected the format of the first image, {}", input.name,
                              InWords(image), InWords(camera.first));
  return false;
}

void LiveCameras::State::Match() {
  auto &left = cameras.front().waiting, &right = cameras.back().waiting;
  if (cameras.size() == 1) {
    Hand({.left = left.back().image, .sensed_at = left.back().at});
    left.clear();
    return;
  }
  while (!left.empty() && !right.empty()) {
    const double skew = SecondsBetween(left.front().at, right.front().at);
    if (std::abs(skew) <= sync) {
      Hand({.left = left.front().image,
            .right = right.front().image,
            .sensed_at = left.front().at + Seconds(skew / 2),
            .skew = skew});
      left.pop_front();
      right.pop_front();
      continue;
    }
    // An older image has no partner.
    ++health.dropped;
    apart = skew;
    (skew > 0 ? left : right).pop_front();
  }
}

void LiveCameras::State::Hand(StereoPair images) {
  images.sequence = ++health.taken;
  health.skew = images.skew;
  matched_at = Clock::now();
  queue.Replace(std::move(images));
}

std::string LiveCameras::State::Trouble(Time now) const {
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (cameras[i].gone) return inputs[i].name + ": disconnected; reconnecting";
    if (!cameras[i].unlike.empty()) return cameras[i].unlike;
  }
  if (inputs.size() < 2 || health.dropped == 0 ||
      SecondsBetween(matched_at, now) < kMaxTimeWithoutPair)
    return {};
  return fmt::format("no pair for {:.1f} s: the images arrive {:.3g} ms apart, sync is {:.3g} ms",
                     SecondsBetween(matched_at, now), 1e3 * std::abs(apart), 1e3 * sync);
}

void LiveCameras::State::AwaitFirst(const std::stop_token& stop) {
  std::unique_lock lock(mutex);
  changed.wait_until(lock, stop, After(timeout), [&] {
    return health.taken > 0 || std::ranges::any_of(cameras, [](const LiveCamera& camera) {
             return !camera.unlike.empty();
           });
  });
  if (health.taken > 0 || stop.stop_requested()) return;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (cameras[i].first.empty() && cameras[i].unlike.empty()) {
      throw std::runtime_error(inputs[i].name + ": no image received");
    }
  }
  const std::string why = Trouble(Clock::now());
  throw std::runtime_error(why.empty() ? inputs.back().name + ": no second image received" : why);
}

LiveCameras::LiveCameras(std::vector<CameraInput> inputs, PairLayout layout, double sync,
                         std::chrono::milliseconds timeout)
    : state_(std::make_shared<State>(std::move(inputs), sync, timeout)), layout_(layout) {
  try {
    for (std::size_t i = 0; i < state_->inputs.size(); ++i) {
      threads_.emplace_back(
          [state = state_, i](const std::stop_token& stop) { state->Run(i, stop); });
      state_->AwaitOpened(i);
    }
  } catch (...) {
    End();
    throw;
  }
}

LiveCameras::~LiveCameras() {
  End();
}

void LiveCameras::End() {
  for (std::jthread& thread : threads_) thread.request_stop();
  for (std::size_t i = 0; i < threads_.size(); ++i) {
    if (!state_->HasEnded(i)) threads_[i].detach();
  }
}

std::optional<StereoPair> LiveCameras::Next(const std::stop_token& stop) {
  state_->AwaitFirst(stop);
  auto images = state_->queue.Take(stop);
  if (!images) return std::nullopt;
  return Arranged(*std::move(images), layout_, description());
}

std::optional<CameraHealth> LiveCameras::health() const {
  const std::lock_guard lock(state_->mutex);
  CameraHealth health = state_->health;
  health.trouble = state_->Trouble(Clock::now());
  return health;
}

std::string LiveCameras::description() const {
  std::string names;
  for (const CameraInput& input : state_->inputs) {
    names += (names.empty() ? "" : " | ") + input.name;
  }
  return names;
}

CameraInput InputOf(const Eye& eye, const cv::Size& size, double rate) {
  const VideoBackend& videos = LoadVideoBackend();
  if (eye.kind == Eye::Kind::kDevice) {
    return {fmt::format("camera {}", eye.device),
            [&videos, eye, size, rate] { return videos.OpenDevice(eye.device, size, rate); }, size};
  }
  return {"stream " + eye.address,
          [&videos, eye] { return videos.OpenUrl(eye.address, kStreamOpenTime); }, size};
}

std::unique_ptr<FrameSource> FramesOf(std::vector<CameraInput> inputs, ImageFilter filter) {
  return LeftImages(PairsOf(std::move(inputs), PairLayout::kOneCamera, 0), std::move(filter));
}

std::unique_ptr<StereoSource> PairsOf(std::vector<CameraInput> inputs, PairLayout layout,
                                      double sync) {
  return std::make_unique<LiveCameras>(std::move(inputs), layout, sync);
}

}  // namespace palpate
