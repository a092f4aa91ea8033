// A recording as a source of frames.
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "slave/capture/finger_poses.h"
#include "slave/capture/tactile_instants.h"
#include "slave/capture/tactile_recording.h"

namespace palpate {
namespace {

constexpr double kSameRate = 0.1;    // of a period: a recording this close is taken as it is
constexpr double kLongestPause = 3;  // periods; longer ones are gaps
constexpr double kHeldPose = 3;      // periods before the first and after the last pose

class RecordedTactile final : public TactileSource {
 public:
  RecordedTactile(const Tactile& tactile, bool paced) : tactile_(tactile), paced_(paced) {
    std::vector<std::string> wanted;
    for (const Finger& finger : tactile.fingers) wanted.push_back(finger.name);
    recording_ = ReadTactileRecording(tactile.file, wanted);
    const double period = 1 / tactile.rate;
    if (!tactile.poses.empty()) {
      poses_.emplace(tactile.poses, tactile.fingers, kHeldPose * period);
      poses_->RequireWithin(recording_.t.front(), recording_.t.back());
    }
    const double recorded = MedianPeriod(recording_.t);
    RefuseSlow(tactile.file, recorded, tactile.rate);
    const double gap = kLongestPause * std::max(period, recorded);
    is_resampled_ = recorded > 0 && std::abs(recorded - period) > kSameRate * period;
    instants_ = is_resampled_ ? SteadyInstants(recording_.t, tactile.rate, gap)
                              : InstantsOfSamples(recording_.t, recorded, gap);
  }

  std::optional<TactileFrame> Next(const std::stop_token& stop) override {
    if (next_ == instants_.size() || stop.stop_requested()) return std::nullopt;
    if (next_ == 0) start_ = Clock::now();
    const TactileInstant& instant = instants_[next_++];
    TactileFrame frame = FrameAt(recording_, instant);
    frame.sequence = next_;
    frame.sensed_at = start_ + Seconds(instant.t - recording_.t.front());
    for (std::size_t i = 0; poses_ && i < tactile_.fingers.size(); ++i) {
      frame.fingers[i].X_SF = poses_->At(tactile_.fingers[i].name, instant.t);
    }
    if (paced_ && !WaitUntil(frame.sensed_at, stop)) return std::nullopt;
    return frame;
  }

  [[nodiscard]] std::string description() const override {
    std::string text = "recording " + tactile_.file.string() + " (" +
                       std::to_string(recording_.t.size()) + " samples";
    if (is_resampled_) {
      text +=
          ", resampled from " + std::to_string(std::lround(1 / MedianPeriod(recording_.t))) + " Hz";
    }
    return text + ")";
  }

 private:
  // False: `stop` was requested first.
  bool WaitUntil(Time time, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    never_.wait_until(lock, stop, Clock::ToSteady(time), [] { return false; });
    return !stop.stop_requested();
  }

  Tactile tactile_;
  bool paced_;
  TactileRecording recording_;
  std::optional<FingerPoses> poses_;
  bool is_resampled_ = false;
  std::vector<TactileInstant> instants_;
  std::size_t next_ = 0;
  Time start_{};  // when the first frame was asked for

  std::mutex mutex_;  // for waiting only
  std::condition_variable_any never_;
};

}  // namespace

std::unique_ptr<TactileSource> OpenTactileRecording(const Scene& scene, bool paced) {
  if (!scene.sense.Find<Tactile>())
    throw std::runtime_error(scene.name + ": the scene has no fingertips");
  if (scene.sense.Find<Tactile>()->source != Tactile::Source::kRecording) {
    throw std::runtime_error(scene.name + ": sense.tactile.source is no recording");
  }
  return std::make_unique<RecordedTactile>(*scene.sense.Find<Tactile>(), paced);
}

}  // namespace palpate
