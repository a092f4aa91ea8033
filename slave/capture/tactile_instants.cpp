#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/statistics/robust.h"
#include "shared/text/text.h"
#include "slave/capture/tactile_recording.h"

namespace palpate {
namespace {

constexpr double kRounding = 1e-6;  // of a period: so late a sample still counts as on time
constexpr double kMissing = 1.5;    // periods from one sample to the next: one is missing between
constexpr std::size_t kNeighbours = 2;  // samples on either side that tell whether a stamp was late
constexpr double kSlowest = 4;          // wanted periods from one sample to the next
constexpr double kJitter = 0.02;        // of a period

// Whether the sample after `i` belongs to another stretch.
bool EndsStretch(const std::vector<double>& t, std::size_t i, double largest_gap) {
  return i + 1 == t.size() || t[i + 1] - t[i] > largest_gap;
}

// How many samples are missing between sample `i` and the next one: as many as are over the
// shortest of all stretches around this step that are as long as their samples say.
int MissingBehind(const std::vector<double>& t, std::size_t i, double period, double largest_gap) {
  if (!(t[i + 1] - t[i] > kMissing * period)) return 0;
  std::size_t first = i, last = i + 1;
  while (first > 0 && i - first < kNeighbours && !EndsStretch(t, first - 1, largest_gap)) --first;
  while (last - i - 1 < kNeighbours && !EndsStretch(t, last, largest_gap)) ++last;
  long missing = std::numeric_limits<long>::max();
  for (std::size_t from = first; from <= i; ++from) {
    for (std::size_t to = i + 1; to <= last; ++to) {
      const long steps = std::lround((t[to] - t[from]) / period);
      missing = std::min(missing, steps - static_cast<long>(to - from));
    }
  }
  return static_cast<int>(std::max(missing, 0L));
}

TactileInstant InstantAt(const std::vector<double>& t, std::size_t before, double at) {
  TactileInstant instant{at, before, 0, false};
  if (before + 1 < t.size()) {
    instant.share = std::clamp((at - t[before]) / (t[before + 1] - t[before]), 0.0, 1.0);
  }
  return instant;
}

}  // namespace

double MedianPeriod(const std::vector<double>& t) {
  if (t.size() < 2) return 0;
  std::vector<double> periods;
  for (std::size_t i = 1; i < t.size(); ++i) periods.push_back(t[i] - t[i - 1]);
  return MedianOf(periods);
}

void RefuseSlow(const std::filesystem::path& file, double period, double rate) {
  if (!(period * rate > kSlowest * (1 + kJitter))) return;
  throw std::runtime_error(fmt::format("{}: {:.3g} Hz: accepted is {:g} Hz or more for {:g} Hz",
                                       file.string(), 1 / period, rate / kSlowest, rate));
}

std::vector<TactileInstant> SteadyInstants(const std::vector<double>& t, double rate,
                                           double largest_gap) {
  std::vector<TactileInstant> instants;
  const double slack = kRounding / rate;
  for (std::size_t first = 0; first < t.size();) {
    std::size_t last = first;
    while (!EndsStretch(t, last, largest_gap)) ++last;
    std::size_t before = first;
    const auto count =
        static_cast<std::size_t>(std::floor((t[last] - t[first] + slack) * rate)) + 1;
    for (std::size_t k = 0; k < count; ++k) {
      const double at = t[first] + static_cast<double>(k) / rate;
      while (before < last && t[before + 1] <= at + slack) ++before;
      instants.push_back(before == last ? TactileInstant{at, last, 0, false}
                                        : InstantAt(t, before, at));
      instants.back().after_gap = k == 0 && first > 0;
    }
    first = last + 1;
  }
  return instants;
}

std::vector<TactileInstant> InstantsOfSamples(const std::vector<double>& t, double period,
                                              double largest_gap) {
  std::vector<TactileInstant> instants;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const bool after_gap = i > 0 && EndsStretch(t, i - 1, largest_gap);
    instants.push_back({t[i], i, 0, after_gap});
    if (EndsStretch(t, i, largest_gap)) continue;
    const double length = t[i + 1] - t[i];
    const int missing = MissingBehind(t, i, period, largest_gap);
    for (int k = 1; k <= missing; ++k) {
      instants.push_back(InstantAt(t, i, t[i] + length * k / (missing + 1)));
    }
  }
  return instants;
}

FingerReading Between(const FingerReading& from, const FingerReading& to, double share) noexcept {
  const auto mix = [share](float a, float b) {
    return static_cast<float>((1 - share) * static_cast<double>(a) +
                              share * static_cast<double>(b));
  };
  FingerReading reading;
  reading.present = from.present && to.present;
  for (std::size_t i = 0; i < reading.electrodes.size(); ++i) {
    reading.electrodes[i] = mix(from.electrodes[i], to.electrodes[i]);
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

TactileFrame FrameAt(const TactileRecording& recording, const TactileInstant& instant) {
  TactileFrame frame;
  frame.after_gap = instant.after_gap;
  for (std::size_t i = 0; i < recording.fingers.size(); ++i) {
    const auto& samples = recording.fingers[i].samples;
    const FingerReading& before = samples[instant.before];
    frame.fingers[i] =
        instant.share > 0 ? Between(before, samples[instant.before + 1], instant.share) : before;
  }
  return frame;
}

std::vector<TactileFrame> Resample(const TactileRecording& recording, double rate,
                                   double largest_gap) {
  Require(rate > 0 && rate <= 1e6, "rate", rate, "> 0, up to 1e6", " Hz");
  if (recording.fingers.size() > kMaxFingers) {
    throw std::invalid_argument(std::to_string(recording.fingers.size()) +
                                " fingers: accepted is at most 5");
  }
  std::vector<TactileFrame> frames;
  for (const TactileInstant& instant : SteadyInstants(recording.t, rate, largest_gap)) {
    frames.push_back(FrameAt(recording, instant));
    frames.back().sequence = frames.size();
    frames.back().sensed_at = Time(Seconds(instant.t - recording.t.front()));
  }
  return frames;
}

}  // namespace palpate
