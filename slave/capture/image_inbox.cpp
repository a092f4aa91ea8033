#include "slave/capture/image_inbox.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/driven_clock.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/capture/image_queue.h"
#include "slave/capture/pace_limit.h"
#include "slave/capture/pair_images.h"
#include "slave/capture/sender_clock.h"

namespace palpate {
namespace {

using Encoding = PushedImage::Encoding;

constexpr double kSenderSilence = 1;  // silence of a sender after which another one is accepted [s]
constexpr double kMaxPerRate = 4;     // samples per second over the scene's rate
constexpr double kMinAllowed = 120;   // samples per second

[[noreturn]] void Refuse(const std::string& why) {
  throw std::runtime_error(why);
}

struct PixelFormat {
  int type, bytes;
  const char* name;
};

PixelFormat FormatOf(Encoding encoding) {
  if (encoding == Encoding::kGrey16) return {CV_16UC1, 2, "GREY16"};
  if (encoding == Encoding::kBgr8) return {CV_8UC3, 3, "BGR8"};
  return {CV_8UC1, 1, "GREY8"};
}

cv::Mat Pixels(const PushedImage& pushed) {
  const PixelFormat format = FormatOf(pushed.encoding);
  const std::uint64_t pixels = std::uint64_t{pushed.width} * pushed.height;
  if (pixels == 0 || pixels > kMaxPixels) {
    Refuse(fmt::format("width = {}, height = {}: expected at least one and at most {} pixels",
                       pushed.width, pushed.height, kMaxPixels));
  }
  const std::uint64_t bytes = pixels * static_cast<unsigned>(format.bytes);
  if (pushed.data->size() != bytes) {
    Refuse(fmt::format("data of {} bytes: expected {} for {} x {} px of {}", pushed.data->size(),
                       bytes, pushed.width, pushed.height, format.name));
  }
  return cv::Mat(static_cast<int>(pushed.height), static_cast<int>(pushed.width), format.type,
                 const_cast<char*>(pushed.data->data()))  // read only
      .clone();
}

// `accepts`: throws if an image of this size is not accepted, before memory is allocated.
template <typename Accepts>
cv::Mat Decoded(const PushedImage& pushed, const Accepts& accepts) {
  if (pushed.encoding != Encoding::kJpeg && pushed.encoding != Encoding::kPng) {
    cv::Mat pixels = Pixels(pushed);
    accepts(pixels.size());
    return pixels;
  }
  const Bytes bytes(reinterpret_cast<const unsigned char*>(pushed.data->data()),
                    pushed.data->size());
  const bool is_jpeg = pushed.encoding == Encoding::kJpeg;
  try {
    const auto coded = is_jpeg ? OpenJpeg(bytes) : OpenPng(bytes);
    if (coded == nullptr)
      Refuse(is_jpeg ? "is not a JPEG image, grey or with three colours" : "is not a PNG image");
    accepts(coded->size());
    return coded->Decode();
  } catch (const std::runtime_error& error) {
    const std::string why = error.what();
    if (why.find(": expected ") != std::string::npos) throw;
    Refuse(fmt::format("the image {}: expected a complete {}", why, is_jpeg ? "JPEG" : "PNG"));
  }
}

// Wanted holds the properties of images that the scene accepts.
struct Wanted {
  PairLayout layout = PairLayout::kOneCamera;
  cv::Size size;  // empty: the first one's
  double rate = 30, sync = 0;
};

Wanted WantedBy(const Scene& scene) {
  Wanted wanted;
  if (const auto* pair = scene.sense.Find<StereoCameras>()) {
    return {PairLayout::kTwoCameras, {pair->size[0], pair->size[1]}, pair->rate, pair->sync};
  }
  if (const auto* depth = scene.sense.Find<DepthImages>()) {
    return {PairLayout::kDepth, {}, depth->rate, 0};
  }
  if (const auto* camera = scene.sense.Find<Camera>()) {
    return {PairLayout::kOneCamera, {camera->size[0], camera->size[1]}, camera->rate, 0};
  }
  throw std::invalid_argument(scene.name + ": the scene has no camera");
}

}  // namespace

struct ImageInbox::State {
  explicit State(const Scene& scene) : wanted(WantedBy(scene)) {}

  // These functions throw std::runtime_error for rejected images. Called without the mutex.
  [[nodiscard]] cv::Mat SizedAsWanted(const PushedImage& pushed) const;
  [[nodiscard]] StereoPair Accepted(const PushedSample& pushed) const;
  // Call it with the mutex locked.
  std::optional<std::string> TooMany(Time arrived_at);
  std::optional<std::string> OutOfOrder(const PushedSample& pushed) const;
  std::optional<std::string> Unlike(const StereoPair& sample);
  void Stamp(const PushedSample& pushed, Time arrived_at, StereoPair* sample);
  void Keep(StereoPair sample);
  // With a driven clock the waiting thread itself would have to feed the sample.
  [[nodiscard]] bool WouldWaitForEver() const {
    return DrivenClock::is_active() && !queue.has_images();
  }

  const Wanted wanted;
  ImageQueue queue;

  mutable PriorityInheritanceMutex mutex;  // guards the members below
  SenderId sender = 0;
  SenderClock clock;
  std::optional<Time> received_at, sensed_at;  // slave's clock; sender's
  std::uint64_t sequence = 0;                  // of the sender's newest
  PaceLimit pace{std::max(kMinAllowed, kMaxPerRate* wanted.rate)};
  cv::Size size;  // of the first
  int type = -1;
  Time newest_at{}, taken_at{};  // times of the last stored sample and of the last returned one
  CameraHealth health;
};

cv::Mat ImageInbox::State::SizedAsWanted(const PushedImage& pushed) const {
  return Decoded(pushed, [this](const cv::Size& is) {
    if (wanted.size.empty() || is == wanted.size) return;
    Refuse(fmt::format("{} x {} px: expected the scene's {} x {} px", is.width, is.height,
                       wanted.size.width, wanted.size.height));
  });
}

StereoPair ImageInbox::State::Accepted(const PushedSample& pushed) const {
  const bool is_pair = wanted.layout == PairLayout::kTwoCameras;
  if (is_pair && !pushed.right)
    Refuse("right is absent: expected a pair, because the scene has a stereo pair");
  if (!is_pair && pushed.right) {
    Refuse("right: expected one image, because the scene has one camera");
  }
  StereoPair sample;
  sample.left = SizedAsWanted(pushed.image);
  if (is_pair) sample.right = SizedAsWanted(*pushed.right);
  if (is_pair && pushed.right_sensed_at) {
    sample.skew = SecondsBetween(pushed.sensed_at, *pushed.right_sensed_at);
  }
  return Arranged(std::move(sample), wanted.layout, "images");
}

std::optional<std::string> ImageInbox::State::TooMany(Time arrived_at) {
  if (pace.Allows(arrived_at)) return std::nullopt;
  return fmt::format("more than {:g} samples within a second: expected the scene's rate, {:g} Hz",
                     pace.max_rate(), wanted.rate);
}

std::optional<std::string> ImageInbox::State::OutOfOrder(const PushedSample& pushed) const {
  if (!sensed_at) return std::nullopt;
  if (pushed.sensed_at <= *sensed_at) {
    return fmt::format("sensed_at: expected a time that increases; this one changed by {} s",
                       SecondsBetween(*sensed_at, pushed.sensed_at));
  }
  if (pushed.sequence == 0 || pushed.sequence > sequence) return std::nullopt;
  return fmt::format("sequence = {}: expected one above the last, {}", pushed.sequence, sequence);
}

std::optional<std::string> ImageInbox::State::Unlike(const StereoPair& sample) {
  if (type < 0) {
    type = sample.left.type();
    size = sample.left.size();
  }
  if (sample.left.type() == type && sample.left.size() == size) return std::nullopt;
  return fmt::format("{} x {} px, {}: expected the format of the first image, {} x {} px, {}",
                     sample.left.cols, sample.left.rows, TypeInWords(sample.left.type()),
                     size.width, size.height, TypeInWords(type));
}

// No image, nor the later one of a pair, arrives before it was taken. The time of a pair is the
// mean of both. Times must rise, even if a new fastest sample changes the clock offset.
void ImageInbox::State::Stamp(const PushedSample& pushed, Time arrived_at, StereoPair* sample) {
  received_at = arrived_at;
  sensed_at = pushed.sensed_at;
  sequence = pushed.sequence;
  const Time latest = pushed.sensed_at + Seconds(std::max(0.0, sample->skew));
  const Time middle = clock.Map(latest + Seconds(pushed.delay), arrived_at) -
                      Seconds(pushed.delay + std::abs(sample->skew) / 2);
  sample->sensed_at = std::max(middle, newest_at + Clock::duration(1));
  newest_at = sample->sensed_at;
}

void ImageInbox::State::Keep(StereoPair sample) {
  ++health.taken;
  if (std::abs(sample.skew) > wanted.sync) {
    ++health.dropped;
    health.trouble =
        fmt::format("the images of a pair are {:.3g} ms apart and are dropped: sync is {:.3g} ms",
                    1e3 * std::abs(sample.skew), 1e3 * wanted.sync);
    return;
  }
  health.trouble.clear();
  queue.Replace(std::move(sample));
}

ImageInbox::ImageInbox(const Scene& scene) : state_(std::make_unique<State>(scene)) {}

ImageInbox::~ImageInbox() = default;

std::optional<ImageInbox::Refusal> ImageInbox::Feed(const PushedSample& pushed, Time arrived_at,
                                                    SenderId sender) {
  State& s = *state_;
  {
    const std::scoped_lock lock(s.mutex);
    const bool is_other = s.sender != 0 && sender != s.sender;
    if (is_other && s.received_at && SecondsBetween(*s.received_at, arrived_at) < kSenderSilence) {
      return Refusal{
          "is already fed by a stream: expected one stream, or a new one a second after the "
          "last sample",
          true};
    }
    if (is_other || s.sender == 0) {
      s.sender = sender;
      s.clock.Reset();
      s.sensed_at.reset();
    }
    if (auto why = s.TooMany(arrived_at)) return Refusal{*std::move(why)};
    if (auto why = s.OutOfOrder(pushed)) return Refusal{*std::move(why)};
  }
  StereoPair sample;
  try {
    sample = s.Accepted(pushed);  // takes some time
  } catch (const std::exception& error) {
    return Refusal{error.what()};
  }
  const std::scoped_lock lock(s.mutex);
  if (s.sender != sender) return Refusal{"is fed by another stream: expected one stream", true};
  if (auto why = s.Unlike(sample)) return Refusal{*std::move(why)};
  s.Stamp(pushed, arrived_at, &sample);
  s.Keep(std::move(sample));
  return std::nullopt;
}

void ImageInbox::Leave(SenderId sender) {
  const std::scoped_lock lock(state_->mutex);
  if (sender == state_->sender) state_->sender = 0;
}

bool ImageInbox::Wait(const std::stop_token& stop) {
  return !state_->WouldWaitForEver() && state_->queue.Wait(stop);
}

void ImageInbox::Drop() {
  const std::scoped_lock lock(state_->mutex);
  state_->queue.Clear();
  state_->type = -1;
}

Time ImageInbox::taken_at() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->taken_at;
}

CameraHealth ImageInbox::health() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->health;
}

std::unique_ptr<FrameSource> ImageInbox::OpenFrames(ImageFilter filter) {
  return LeftImages(OpenPairs(), std::move(filter));
}

std::unique_ptr<StereoSource> ImageInbox::OpenPairs() {
  class Pairs final : public StereoSource {
   public:
    explicit Pairs(State& state) : state_(state) {}
    std::optional<StereoPair> Next(const std::stop_token& stop) override {
      if (state_.WouldWaitForEver()) return std::nullopt;
      auto sample = state_.queue.Take(stop);
      if (!sample) return std::nullopt;
      sample->sequence = ++count_;
      const std::scoped_lock lock(state_.mutex);
      state_.taken_at = sample->sensed_at;
      state_.health.skew = sample->skew;
      return sample;
    }
    [[nodiscard]] std::string description() const override {
      return "images from a driver (FeedImages)";
    }

   private:
    State& state_;
    std::uint64_t count_ = 0;
  };
  return std::make_unique<Pairs>(*state_);
}

}  // namespace palpate
