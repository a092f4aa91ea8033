#include "slave/tactile/rest_trend.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/statistics/robust.h"

namespace palpate {
namespace {

constexpr double kSpike = 20;       // from the line at most, lest one sample draws it [counts]
constexpr double kStandsOut = 2;    // times the slopes' variance
constexpr double kStandsAlone = 9;  // likewise of a single one
// What is known of k beforehand, one sigma about 0: drift that goes on, or ends within a second.
constexpr double kBendSigma = 0.02;   // [1/sample]
constexpr double kLargestBend = 0.1;  // [1/sample]
constexpr double kRough = 0.05;       // of k: no fingertip follows an exponential
// That a slope seen last goes on, about [samples]. [tuned: WhereADriftMayHaveGoneIsADirection]
constexpr double kLasts = 1000;
constexpr double kRounding =
    1.0 / 12;                    // [counts^2] [derived: variance of rounding to whole counts]
constexpr double kBends = 0.05;  // part of a slope that may have changed by itself
constexpr double kFollowing = 2, kDrifting = 0.2;  // of rest values while nothing is near [s]
// What rest values may be followed up to, averaged over some samples: more of both is a contact.
constexpr double kLevelling = 0.1;  // share of a sample in what is averaged over some
constexpr double kStillElectrode = 1, kStillPressure = 2;  // [counts]
constexpr double kFew = 4;  // times as much counts of a single electrode
// A step of all electrodes alike: at least so large [counts], and over their scatter about it.
constexpr double kStep = 3, kAlike = 3;
constexpr double kStepsLast = 0.97;  // part of what is left of a step in the next sample

double Signal(const FingerReading& reading, std::size_t i) noexcept {
  if (i < kElectrodeCount) return static_cast<double>(reading.electrodes[i]);
  return static_cast<double>(i == kElectrodeCount ? reading.pac : reading.pdc);
}

// From squares of which a few may be of electrodes that do not work.
double VarianceOf(std::array<double, kElectrodeCount>& squares) noexcept {
  constexpr double kMedian = 0.455;  // [-] [derived: median of the square of a standard normal]
  return MedianOf(squares) / kMedian;
}

// Of slopes of this mean square that is used, where `noise2` is none.
double Part(double slope2, double noise2) noexcept {
  return slope2 > 0 ? std::max(0.0, 1 - noise2 / slope2) : 0;
}

}  // namespace

void RestTrend::Advance() noexcept {
  auto& [n, t, t2, t3, t4] = times_;
  t4 += -4 * t3 + 6 * t2 - 4 * t + n;
  t3 += -3 * t2 + 3 * t - n;
  t2 += -2 * t + n;
  t -= n;
  for (Moments& m : moments_) {
    m.timed[2] += -2 * m.timed[1] + m.timed[0];
    m.timed[1] -= m.timed[0];
  }
  ++since_;
}

void RestTrend::Take(const FingerReading& reading, double keep) noexcept {
  const bool is_fitted = known();
  if (taken_ == 0) origin_ = reading;
  ++taken_;
  since_ = 0;
  for (double& sum : times_) sum *= keep;
  times_[0] += 1;
  for (std::size_t i = 0; i < kSignalCount; ++i) {
    const double level = lines_[i].level;
    const double read = Signal(reading, i) - Signal(origin_, i);
    const double x = is_fitted ? std::clamp(read, level - kSpike, level + kSpike) : read;
    Moments& m = moments_[i];
    for (double& sum : m.timed) sum *= keep;
    m.timed[0] += x;
    m.squared = keep * m.squared + x * x;
  }
  if (known()) Fit();
}

void RestTrend::Shift(double by) noexcept {
  for (float& electrode : origin_.electrodes) electrode += static_cast<float>(by);
}

// A contact moves electrodes and pressure; what only one of them does, or neither, is drift.
void RestTrend::Follow(const FingerReading& reading) noexcept {
  const TactileSignals change = Change(reading);
  double electrodes = 0;
  for (std::size_t i = 0; i < change.size(); ++i) {
    clear_[i] += kLevelling * (change[i] - clear_[i]);
    if (i < kElectrodeCount) {  // one that does not work must not speak for all
      electrodes += std::min(clear_[i] * clear_[i], kStillElectrode * kFew);
    }
  }
  const double pressure = clear_[kElectrodeCount + 1];
  const bool moves = electrodes > kElectrodeCount * kStillElectrode * kStillElectrode;
  if (moves && pressure > kStillPressure) return;
  const bool drifts = moves || std::abs(pressure) > kStillPressure;
  const double keep = std::exp(-1 / ((drifts ? kDrifting : kFollowing) * rate_));
  Take(reading, keep);
  for (double& average : clear_) average *= keep;
}

// A contact moves each electrode its own way. What moves all of them alike, from one sample to the
// next, is the electronics.
void RestTrend::FollowSteps(const FingerReading& reading, bool looks_back) noexcept {
  const auto last = std::exchange(before_, reading.electrodes);
  if (!looks_back) return;
  std::array<double, kElectrodeCount> moved{};
  for (std::size_t i = 0; i < moved.size(); ++i) {
    moved[i] = static_cast<double>(reading.electrodes[i] - last[i]);
  }
  const double step = MedianOf(moved);
  const double scatter = SigmaAboutMedian(moved);
  const bool steps = std::abs(step) > std::max(kStep, kAlike * scatter);
  if (steps) Shift(step);
  steps_ = kStepsLast * steps_ + (steps ? 1 : 0);
}

double RestTrend::Ahead() const noexcept {
  return kLasts * -std::expm1(-since_ / kLasts);
}

double RestTrend::Way(double t) const noexcept {
  if (t < 0) return t - bend_ / 2 * t * t;  // as it was fitted
  return bend_ > 0 ? -std::expm1(-bend_ * t) / bend_ : t;
}

TactileSignals RestTrend::Change(const FingerReading& reading, double ago) const noexcept {
  TactileSignals change{};
  const double way = Way(since_ > 0 ? Ahead() : -ago);
  for (std::size_t i = 0; i < kSignalCount; ++i) {
    const Line& line = lines_[i];
    change[i] = Signal(reading, i) - Signal(origin_, i) - line.level - way * line.slope;
  }
  return change;
}

double RestTrend::variance() const noexcept {
  const double way = Way(Ahead());
  return way * way * slope_variance_;
}

double RestTrend::pressure_variance() const noexcept {
  const double ahead = Way(Ahead()) - middle_;
  return pressure_noise2_ * (1 / times_[0] + ahead * ahead * pressure_slope2_);
}

TactileSignals RestTrend::astray() const noexcept {
  // dh/dk
  const double t = Ahead(), z = bend_ * t;
  const double change = z > 1e-3 ? (1 - std::exp(-z) * (1 + z)) / (bend_ * bend_) : t * t / 2;
  TactileSignals astray{};
  for (std::size_t i = 0; i < kSignalCount; ++i) astray[i] = change * bend_sigma_ * lines_[i].slope;
  return astray;
}

RestTrend::Times RestTrend::TimesNow() const noexcept {
  const auto mean = [&](std::size_t n) { return times_[n] / times_[0]; };
  const double m = mean(1), m2 = m * m;
  const double spread = mean(2) - m2;
  if (!(spread > 0)) return {.middle = m};
  const double third = mean(3) - 3 * m * mean(2) + 2 * m * m2;
  const double fourth = mean(4) - 4 * m * mean(3) + 6 * m2 * mean(2) - 3 * m2 * m2;
  const double skew = third / spread;
  return {m, spread, skew, std::max(0.0, fourth - third * skew - spread * spread)};
}

void RestTrend::Fit() noexcept {
  const Times times = TimesNow();
  bend_ = 0;
  bend_sigma_ = kBendSigma;
  part_ = 0;
  if (times.spread > 0 && times.beyond > 0) FitBend(times);
  FitLines();
}

// By straight lines and what a parabola has besides, each by least squares: the slopes in the
// middle change by -k of them a sample.
void RestTrend::FitBend(const Times& times) noexcept {
  const auto [middle, spread, skew, beyond] = times;
  std::array<double, kElectrodeCount> slopes2, noise2;
  double together = 0, slopes = 0;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const Moments& m = moments_[i];
    const auto mean = [&](std::size_t n) { return m.timed[n] / times_[0]; };
    const double along = mean(1) - middle * mean(0);
    const double square = mean(2) - 2 * middle * mean(1) + middle * middle * mean(0);
    const double slope = along / spread;
    const double parabola = (square - skew * along - spread * mean(0)) / beyond;
    slopes2[i] = slope * slope;
    noise2[i] = std::max(0.0, m.squared / times_[0] - mean(0) * mean(0) - slopes2[i] * spread -
                                  parabola * parabola * beyond);
    together += slope * parabola;
    slopes += slopes2[i];
  }
  noise2_ = std::max(VarianceOf(noise2), kRounding);  // a simulated one has none
  const double slope2 = VarianceOf(slopes2), slope_variance = noise2_ / (times_[0] * spread);
  part_ = Part(slope2, kStandsOut * slope_variance);
  const double sure = slopes - kElectrodeCount * slope_variance;
  if (part_ == 0 || sure <= 0) return;
  const double bend = -2 * together / sure, variance = 4 * noise2_ / (times_[0] * beyond) / sure;
  const double usual = 1 / (kBendSigma * kBendSigma), seen = 1 / variance;
  bend_ = std::clamp(seen * bend / (usual + seen), 0.0, kLargestBend);
  bend_sigma_ = std::hypot(1 / std::sqrt(usual + seen), kRough * bend_);
}

void RestTrend::FitLines() noexcept {
  const auto mean = [&](std::size_t n) { return times_[n] / times_[0]; };
  const double k = bend_ / 2;
  middle_ = mean(1) - k * mean(2);
  const double spread = mean(2) - 2 * k * mean(3) + k * k * mean(4) - middle_ * middle_;
  const double known = spread > 0 ? 1 / (times_[0] * spread) : 0;  // of a slope, times its noise
  std::array<double, kElectrodeCount> slopes2{};
  for (std::size_t i = 0; i < kSignalCount; ++i) {
    if (i == kElectrodeCount) continue;  // pac0 is a rate itself
    const Moments& m = moments_[i];
    const double level = m.timed[0] / times_[0];
    const double along = (m.timed[1] - k * m.timed[2]) / times_[0] - middle_ * level;
    const double slope = along * times_[0] * known, slope2 = slope * slope;
    double part = part_;
    if (i < kElectrodeCount) {
      slopes2[i] = slope2;
    } else {  // the pressure drifts by itself, too
      pressure_noise2_ = std::max(0.0, m.squared / times_[0] - level * level - slope2 * spread);
      part = std::max(part, Part(slope2, kStandsAlone * known * pressure_noise2_));
      pressure_slope2_ = part * part * known;
    }
    lines_[i] = {level - middle_ * part * slope, part * slope};
  }
  lines_[kElectrodeCount] = {moments_[kElectrodeCount].timed[0] / times_[0], 0};
  slope_variance_ = part_ * (known * noise2_ + kBends * kBends * part_ * VarianceOf(slopes2));
}

}  // namespace palpate
