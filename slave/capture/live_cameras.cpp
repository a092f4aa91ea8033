#include "slave/capture/live_cameras.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

constexpr std::size_t kKept = 4;  // pictures per eye that may still find theirs
constexpr auto kRetry = std::chrono::milliseconds(250);  // until an eye that went is looked for
constexpr auto kEnds = std::chrono::seconds(3);          // a thread that is asked to
constexpr auto kAnswers = std::chrono::seconds(5);       // a stream that is opened
constexpr double kNoPair = 1;                            // [s] without one is told

// Empty: there is no image any more. An exception of the library counts as a camera that is gone.
cv::Mat NextOf(Film* film) {
  try {
    return film != nullptr ? film->Next() : cv::Mat();
  } catch (const std::exception&) {
    return {};
  }
}

struct Taken {
  cv::Mat picture;
  Time at{};
};

// What all pictures of an eye have in common with its first.
struct ImageFormat {
  cv::Size size;  // empty: none came yet
  int type = -1;
};

// Of an eye's thread.
enum class Stage : std::uint8_t { kOpening, kOpened, kEnded };

std::string InWords(const ImageFormat& image_format) {
  return fmt::format("{} x {} px, {} channel{} of {} bit", image_format.size.width,
                     image_format.size.height, CV_MAT_CN(image_format.type),
                     CV_MAT_CN(image_format.type) == 1 ? "" : "s",
                     8 * CV_ELEM_SIZE1(image_format.type));
}

}  // namespace

struct LiveCameras::State {
  State(std::vector<CameraInput> of, double most_apart, std::chrono::milliseconds longest)
      : inputs(std::move(of)), sync(most_apart), patience(longest) {
    queues.resize(inputs.size());
    gone.resize(inputs.size());
    stages.resize(inputs.size(), Stage::kOpening);
    refusals.resize(inputs.size());
    firsts.resize(inputs.size());
    unlike.resize(inputs.size());
  }

  // An eye's thread. Opening and reading it are another library's, which may never come back.
  void Watch(std::size_t eye, const std::stop_token& stop);
  void WatchOpened(std::size_t eye, std::unique_ptr<Film> film, const std::stop_token& stop);
  void Reach(std::size_t eye, Stage stage);
  // Throws std::runtime_error: it is not there, or does not answer.
  void AwaitOpened(std::size_t eye);
  [[nodiscard]] bool HasEnded(std::size_t eye);  // waits for it, not forever
  void Put(std::size_t eye, cv::Mat picture, Time at);
  void SetGone(std::size_t eye, bool is_gone);
  // With the mutex, as those below. Whether the eye's picture is like those before; told if not.
  bool IsLikeFirst(std::size_t eye, const cv::Mat& picture);
  // The newest pictures that belong together, as far as they have come.
  void Match();
  [[nodiscard]] std::string Trouble(Time now) const;
  // Throws std::runtime_error: what comes will not do, or nothing comes.
  void AwaitFirst(std::unique_lock<std::mutex>& lock, const std::stop_token& stop);

  const std::vector<CameraInput> inputs;
  const double sync;
  const std::chrono::milliseconds patience;

  mutable std::mutex mutex;  // guards what follows
  std::condition_variable_any changed;
  std::vector<std::deque<Taken>> queues;
  std::vector<bool> gone;
  std::vector<Stage> stages;
  std::vector<std::exception_ptr> refusals;  // of the first opening
  std::vector<ImageFormat> firsts;
  std::vector<std::string> unlike;  // of each eye's newest picture, in words; empty: nothing
  std::optional<Shot> slot;
  std::uint64_t shots = 0;
  CameraHealth health;
  double apart = 0;  // of the pair dropped last [s]
  Time matched_at = Clock::now();
};

void LiveCameras::State::Watch(std::size_t eye, const std::stop_token& stop) {
  std::unique_ptr<Film> film;
  try {
    film = inputs[eye].open();
    if (!film) {
      throw std::runtime_error(inputs[eye].name +
                               ": no such camera or stream, no permission, or no answer");
    }
    Reach(eye, Stage::kOpened);
    WatchOpened(eye, std::move(film), stop);
  } catch (const std::exception&) {
    const std::lock_guard lock(mutex);
    refusals[eye] = std::current_exception();
  }
  Reach(eye, Stage::kEnded);
}

void LiveCameras::State::Reach(std::size_t eye, Stage stage) {
  {
    const std::lock_guard lock(mutex);
    stages[eye] = stage;
  }
  changed.notify_all();
}

void LiveCameras::State::AwaitOpened(std::size_t eye) {
  std::unique_lock lock(mutex);
  changed.wait_for(lock, patience, [&] { return stages[eye] != Stage::kOpening; });
  if (stages[eye] == Stage::kOpening) {
    throw std::runtime_error(fmt::format("{}: no answer within {:g} s", inputs[eye].name,
                                         std::chrono::duration<double>(patience).count()));
  }
  if (refusals[eye]) std::rethrow_exception(refusals[eye]);
}

bool LiveCameras::State::HasEnded(std::size_t eye) {
  std::unique_lock lock(mutex);
  return changed.wait_for(lock, kEnds, [&] { return stages[eye] == Stage::kEnded; });
}

void LiveCameras::State::WatchOpened(std::size_t eye, std::unique_ptr<Film> film,
                                     const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    cv::Mat picture = NextOf(film.get());
    if (!picture.empty()) {
      Put(eye, std::move(picture), Clock::now());
      continue;
    }
    film.reset();  // before it is opened again
    SetGone(eye, true);
    {
      std::unique_lock lock(mutex);
      changed.wait_for(lock, stop, kRetry, [] { return false; });
    }
    if (stop.stop_requested()) return;
    try {
      film = inputs[eye].open();
    } catch (const std::exception&) {  // it is still not there
    }
    if (film) SetGone(eye, false);
  }
}

void LiveCameras::State::SetGone(std::size_t eye, bool is_gone) {
  const std::lock_guard lock(mutex);
  gone[eye] = is_gone;
  if (is_gone) queues[eye].clear();
}

void LiveCameras::State::Put(std::size_t eye, cv::Mat picture, Time at) {
  {
    const std::lock_guard lock(mutex);
    if (IsLikeFirst(eye, picture)) {
      auto& queue = queues[eye];
      queue.push_back({std::move(picture), at});
      if (queue.size() > kKept) queue.pop_front();
      Match();
    }
  }
  changed.notify_all();
}

bool LiveCameras::State::IsLikeFirst(std::size_t eye, const cv::Mat& picture) {
  const CameraInput& input = inputs[eye];
  const ImageFormat image_format{picture.size(), picture.type()};
  ImageFormat& first = firsts[eye];
  if (first.size.empty() && !input.size.empty() && image_format.size != input.size) {
    unlike[eye] = fmt::format(
        "{}: {} x {} px: accepted is {} x {} px, the size in the scene or its rig", input.name,
        image_format.size.width, image_format.size.height, input.size.width, input.size.height);
    return false;
  }
  if (first.size.empty()) first = image_format;
  const bool is_like = image_format.size == first.size && image_format.type == first.type;
  unlike[eye] = is_like ? std::string()
                        : fmt::format("{}: {}: accepted is the format of the first image, {}",
                                      input.name, InWords(image_format), InWords(first));
  return is_like;
}

void LiveCameras::State::Match() {
  auto& left = queues.front();
  if (queues.size() == 1) {
    slot = Shot{{left.back().picture}, ++shots, left.back().at, 0};
    left.clear();
    ++health.taken;
    return;
  }
  auto& right = queues.back();
  while (!left.empty() && !right.empty()) {
    const double skew = SecondsBetween(left.front().at, right.front().at);
    if (std::abs(skew) <= sync) {
      slot = Shot{{left.front().picture, right.front().picture},
                  ++shots,
                  left.front().at + Seconds(skew / 2),
                  skew};
      health.skew = skew;
      ++health.taken;
      matched_at = Clock::now();
      left.pop_front();
      right.pop_front();
      continue;
    }
    // What is older finds no other any more.
    ++health.dropped;
    apart = skew;
    (skew > 0 ? left : right).pop_front();
  }
}

std::string LiveCameras::State::Trouble(Time now) const {
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (gone[i]) return inputs[i].name + ": disconnected; reconnecting";
    if (!unlike[i].empty()) return unlike[i];
  }
  if (inputs.size() < 2 || health.dropped == 0 || SecondsBetween(matched_at, now) < kNoPair)
    return {};
  return fmt::format("no pair for {:.1f} s: the images arrive {:.3g} ms apart, sync is {:.3g} ms",
                     SecondsBetween(matched_at, now), 1e3 * std::abs(apart), 1e3 * sync);
}

void LiveCameras::State::AwaitFirst(std::unique_lock<std::mutex>& lock,
                                    const std::stop_token& stop) {
  const auto is_unlike = [](const std::string& why) { return !why.empty(); };
  changed.wait_for(lock, stop, patience,
                   [&] { return slot.has_value() || std::ranges::any_of(unlike, is_unlike); });
  if (slot || stop.stop_requested()) return;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (firsts[i].size.empty() && unlike[i].empty()) {
      throw std::runtime_error(inputs[i].name + ": no image received");
    }
  }
  const std::string why = Trouble(Clock::now());
  throw std::runtime_error(why.empty() ? inputs.back().name + ": no second image received" : why);
}

LiveCameras::LiveCameras(std::vector<CameraInput> inputs, double sync,
                         std::chrono::milliseconds patience)
    : state_(std::make_shared<State>(std::move(inputs), sync, patience)) {
  try {
    for (std::size_t i = 0; i < state_->inputs.size(); ++i) {
      threads_.emplace_back(
          [state = state_, i](const std::stop_token& stop) { state->Watch(i, stop); });
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

std::optional<LiveCameras::Shot> LiveCameras::Next(const std::stop_token& stop) {
  State& s = *state_;
  std::unique_lock lock(s.mutex);
  if (s.shots == 0) s.AwaitFirst(lock, stop);
  const bool is_there = s.changed.wait(lock, stop, [&s] { return s.slot.has_value(); });
  if (!is_there || stop.stop_requested()) return std::nullopt;
  return std::exchange(s.slot, std::nullopt);
}

CameraHealth LiveCameras::health() const {
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

namespace {

void RequireUnit(const std::string& name, double is, double accepted) {
  if (is == 0 || std::abs(is / accepted - 1) < 1e-6) return;
  throw std::runtime_error(
      fmt::format("{}: one count is {:g} mm: accepted is the value of sense.camera.unit, {:g} mm",
                  name, 1e3 * is, 1e3 * accepted));
}

}  // namespace

CameraInput InputOf(const Eye& eye, const cv::Size& size, double rate, double unit) {
  if (eye.kind == Eye::Kind::kOpenNi) {
    const std::string name = fmt::format("OpenNI2 depth camera {}", eye.device);
    return {name, [name, eye, unit] {
              auto film = OpenDepthCamera(eye.device);
              if (film) RequireUnit(name, film->unit(), unit);
              return film;
            }};
  }
  const Films& films = LoadFilms();
  if (eye.kind == Eye::Kind::kDevice) {
    return {fmt::format("camera {}", eye.device),
            [&films, eye, size, rate] { return films.OpenDevice(eye.device, size, rate); }, size};
  }
  return {"stream " + eye.address, [&films, eye] { return films.OpenUrl(eye.address, kAnswers); },
          size};
}

namespace {

class LiveFrames final : public FrameSource {
 public:
  LiveFrames(std::vector<CameraInput> inputs, PictureFilter filter)
      : eyes_(std::move(inputs), 0), filter_(std::move(filter)) {}
  std::optional<Frame> Next(const std::stop_token& stop) override {
    auto shot = eyes_.Next(stop);
    if (!shot) return std::nullopt;
    cv::Mat& picture = shot->pictures.front();
    return Frame{filter_ ? filter_(picture) : picture, shot->sequence, shot->sensed_at};
  }
  [[nodiscard]] std::string description() const override { return eyes_.description(); }
  [[nodiscard]] std::optional<CameraHealth> health() const override { return eyes_.health(); }

 private:
  LiveCameras eyes_;
  PictureFilter filter_;
};

class LivePairs final : public StereoSource {
 public:
  LivePairs(std::vector<CameraInput> inputs, PairLayout layout, double sync)
      : eyes_(std::move(inputs), sync), layout_(layout) {}
  std::optional<StereoPair> Next(const std::stop_token& stop) override {
    const auto shot = eyes_.Next(stop);
    if (!shot) return std::nullopt;
    StereoPair pair = PairFrom(shot->pictures, layout_, eyes_.description());
    pair.sequence = shot->sequence;
    pair.sensed_at = shot->sensed_at;
    pair.skew = shot->skew;
    return pair;
  }
  [[nodiscard]] std::string description() const override { return eyes_.description(); }
  [[nodiscard]] std::optional<CameraHealth> health() const override { return eyes_.health(); }

 private:
  LiveCameras eyes_;
  PairLayout layout_;
};

cv::Mat Grey(const cv::Mat& picture, const std::string& name) {
  if (picture.depth() != CV_8U) {
    throw std::runtime_error(name + ": 16 bit: accepted for a pair of cameras is 8 bit");
  }
  if (picture.channels() == 1) return picture;
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

}  // namespace

StereoPair PairFrom(const std::vector<cv::Mat>& pictures, PairLayout layout,
                    const std::string& name) {
  StereoPair pair;
  const cv::Mat& first = pictures.front();
  if (layout == PairLayout::kDepth) {
    if (first.type() != CV_16UC1) {
      throw std::runtime_error(
          fmt::format("{}: {} channel(s) of {} bit: accepted for depth is one channel of 16 bit",
                      name, first.channels(), 8 * first.elemSize1()));
    }
    pair.left = first;
    return pair;
  }
  const cv::Mat left = Grey(first, name);
  if (layout == PairLayout::kSideBySide) {
    if (left.cols % 2 != 0) {
      throw std::runtime_error(
          fmt::format("{}: {} px wide: accepted side by side is an even number", name, left.cols));
    }
    pair.left = left.colRange(0, left.cols / 2).clone();
    pair.right = left.colRange(left.cols / 2, left.cols).clone();
    return pair;
  }
  pair.left = left;
  pair.right = Grey(pictures.back(), name);
  if (pair.left.size() != pair.right.size()) {
    throw std::runtime_error(
        fmt::format("{}: {} x {} and {} x {} px: accepted are images of one size", name,
                    pair.left.cols, pair.left.rows, pair.right.cols, pair.right.rows));
  }
  return pair;
}

std::unique_ptr<FrameSource> FramesOf(std::vector<CameraInput> inputs, PictureFilter filter) {
  return std::make_unique<LiveFrames>(std::move(inputs), std::move(filter));
}

std::unique_ptr<StereoSource> PairsOf(std::vector<CameraInput> inputs, PairLayout layout,
                                      double sync) {
  return std::make_unique<LivePairs>(std::move(inputs), layout, sync);
}

}  // namespace palpate
