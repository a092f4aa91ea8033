// A recording as a source of frames.
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/state/driven_clock.h"
#include "slave/capture/tactile_recording.h"
#include "slave/statistics/robust.h"

namespace palpate {
namespace {

constexpr double kSameRate = 0.1;  // relative difference of periods below which none is resampled
// Periods of the scene from one recorded sample to the next.
constexpr double kSlowestRecording = 4;
constexpr double kJitter = 0.02;    // relative, of the recorded period
constexpr double kRounding = 1e-6;  // periods that a sample may be late and still count

// The median of the times between two samples [s]; 0: fewer than two samples.
double MedianPeriod(const std::vector<double>& t) {
  if (t.size() < 2) return 0;
  std::vector<double> periods;
  for (std::size_t i = 1; i < t.size(); ++i) periods.push_back(t[i] - t[i - 1]);
  return MedianOf(periods);
}

// Time of a frame, and the samples before and after it.
struct Instant {
  double t = 0;           // [s], of the recording's clock
  std::size_t after = 0;  // index of the sample at or after it
  double share = 1;       // weight of that sample, > 0; the previous sample has the rest
  bool after_gap = false;
};

// Returns instants `step` [s] apart (0: at each sample), which restart after a pause longer than
// `gap` [s].
std::vector<Instant> InstantsOf(const std::vector<double>& t, double step, double gap) {
  std::vector<Instant> instants;
  double start = 0;  // time of the first sample after a gap
  double count = 0;  // number of instants since then
  for (std::size_t i = 0; i < t.size(); ++i) {
    const bool after_gap = i > 0 && t[i] - t[i - 1] > gap;
    if (i == 0 || after_gap || step == 0) {
      instants.push_back({t[i], i, 1, after_gap});
      start = t[i];
      count = 1;
      continue;
    }
    for (; start + count * step <= t[i] + kRounding * step; ++count) {
      const double at = start + count * step;
      instants.push_back({at, i, std::min((at - t[i - 1]) / (t[i] - t[i - 1]), 1.0), false});
    }
  }
  return instants;
}

class RecordedTactile final : public TactileSource {
 public:
  explicit RecordedTactile(const Tactile& tactile) : tactile_(tactile) {
    std::vector<std::string> wanted;
    for (const Finger& finger : tactile.fingers) wanted.push_back(finger.name);
    recording_ = ReadTactileRecording(tactile.file, wanted, tactile.channels);
    const double period = 1 / tactile.rate;
    const double recorded = MedianPeriod(recording_.t);
    if (recorded > kSlowestRecording * (1 + kJitter) * period) {
      throw std::runtime_error(fmt::format("{}: {:.3g} Hz: expected {:g} Hz or more for {:g} Hz",
                                           tactile.file.string(), 1 / recorded,
                                           tactile.rate / kSlowestRecording, tactile.rate));
    }
    is_resampled_ = recorded > 0 && std::abs(recorded - period) > kSameRate * period;
    instants_ = InstantsOf(recording_.t, is_resampled_ ? period : 0,
                           kMaxPause * std::max(period, recorded));
  }

  std::optional<TactileFrame> Next(const std::stop_token& stop) override {
    if (next_ == instants_.size() || stop.stop_requested()) return std::nullopt;
    if (next_ == 0) start_ = Clock::now();
    const Instant& instant = instants_[next_++];
    TactileFrame frame;
    frame.sequence = next_;
    frame.sensed_at = start_ + Seconds(instant.t - recording_.t.front());
    frame.after_gap = instant.after_gap;
    for (std::size_t i = 0; i < tactile_.fingers.size(); ++i) {
      const std::vector<FingerReading>& samples = recording_.fingers[i].samples;
      const FingerReading& after = samples[instant.after];
      frame.fingers[i] =
          instant.share < 1 ? Between(samples[instant.after - 1], after, instant.share) : after;
    }
    if (!WaitUntil(frame.sensed_at, stop)) return std::nullopt;
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
    if (DrivenClock::Reach(time)) return true;
    std::unique_lock lock(mutex_);
    never_.wait_until(lock, stop, Clock::ToSteady(time), [] { return false; });
    return !stop.stop_requested();
  }

  Tactile tactile_;
  TactileRecording recording_;
  bool is_resampled_ = false;
  std::vector<Instant> instants_;
  std::size_t next_ = 0;
  Time start_{};  // when the first frame was requested

  std::mutex mutex_;  // for waiting only
  std::condition_variable_any never_;
};

}  // namespace

FingerReading Between(const FingerReading& from, const FingerReading& to, double share) noexcept {
  const auto mix = [share](float a, float b) {
    return static_cast<float>((1 - share) * static_cast<double>(a) +
                              share * static_cast<double>(b));
  };
  FingerReading reading;
  reading.present = from.present && to.present;
  reading.channels.resize(std::min(from.channels.size(), to.channels.size()));
  for (std::size_t i = 0; i < reading.channels.size(); ++i) {
    reading.channels[i] = mix(from.channels[i], to.channels[i]);
  }
  reading.pac = mix(from.pac, to.pac);
  reading.pdc = mix(from.pdc, to.pdc);
  if (from.X_SF && to.X_SF) reading.X_SF = Between(*from.X_SF, *to.X_SF, share);
  return reading;
}

Eigen::Isometry3d Between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                          double share) noexcept {
  const Eigen::Quaterniond q_from(from.linear());
  const Eigen::Quaterniond q_to(to.linear());
  Eigen::Isometry3d between = Eigen::Isometry3d::Identity();
  between.translation() = (1 - share) * from.translation() + share * to.translation();
  between.linear() = q_from.slerp(share, q_to).normalized().toRotationMatrix();
  return between;
}

// A recording as a source of frames.
std::unique_ptr<TactileSource> OpenTactileRecording(const Scene& scene) {
  if (!scene.sense.Find<Tactile>())
    throw std::runtime_error(scene.name + ": the scene has no fingertips");
  if (scene.sense.Find<Tactile>()->source != Tactile::Source::kRecording) {
    throw std::runtime_error(scene.name + ": sense.tactile.source is not a recording");
  }
  return std::make_unique<RecordedTactile>(*scene.sense.Find<Tactile>());
}

}  // namespace palpate
