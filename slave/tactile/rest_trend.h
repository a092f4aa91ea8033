// What a fingertip reads untouched, and where that is going: electrodes drift while they touch,
// too, when nothing tells how far.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "slave/tactile/rest_values.h"

namespace palpate {

// A line through the samples in which nothing touched, each signal for itself, older ones counting
// less. Its slope is used as far as the electrodes' slopes together stand out of their noise
// (W. James and C. Stein, 4th Berkeley Symposium, 1961): fingertips at their temperature have none,
// and theirs would be noise alone.
class RestTrend {
 public:
  explicit RestTrend(int samples) : wanted_(samples) {}

  void Reset() noexcept { *this = RestTrend(wanted_); }
  [[nodiscard]] bool known() const noexcept { return taken_ >= wanted_; }

  // A sample's period goes by. Call before Take.
  void Advance() noexcept {
    squared_time_ += weight_ - 2 * time_;
    time_ -= weight_;
    for (std::size_t i = 0; i < kSignalCount; ++i) moments_[i].timed -= moments_[i].sum;
    ++since_;
  }
  // Nothing touches in this sample; what was before keeps the part `keep` of its weight [0, 1].
  void Take(const FingerReading& reading, double keep = 1) noexcept {
    if (taken_ == 0) origin_ = reading;
    ++taken_;
    since_ = 0;
    weight_ = keep * weight_ + 1;
    time_ *= keep;
    squared_time_ *= keep;
    for (std::size_t i = 0; i < kSignalCount; ++i) {
      const double level = lines_[i].level;
      const double read = Signal(reading, i) - Signal(origin_, i);
      const double x = known() ? std::clamp(read, level - kSpike, level + kSpike) : read;
      Moments& m = moments_[i];
      m = {keep * m.sum + x, keep * m.timed, keep * m.squared + x * x};
    }
    if (known()) Fit();
  }
  // All electrodes have moved by this at once, and will stay there [counts].
  void Shift(double by) noexcept {
    for (float& electrode : origin_.electrodes) electrode += static_cast<float>(by);
  }

  // Counts minus rest of a sample `ago` samples before the last one. Call when known.
  [[nodiscard]] TactileSignals Change(const FingerReading& reading, double ago = 0) const noexcept {
    TactileSignals change{};
    const double lead = since_ > 0 ? Lead() : -ago;
    for (std::size_t i = 0; i < kSignalCount; ++i) {
      const Line& line = lines_[i];
      change[i] = Signal(reading, i) - Signal(origin_, i) - line.level - lead * line.slope;
    }
    return change;
  }
  // Of an electrode's rest value now, beyond what a fingertip without drift has [counts^2].
  [[nodiscard]] double variance() const noexcept {
    return since_ > 0 ? Lead() * Lead() * slope_variance_ : 0;
  }
  // Of the pressure's [counts^2].
  [[nodiscard]] double pressure_variance() const noexcept {
    const double ahead = Lead() - middle_;
    return pressure_noise2_ * (1 / weight_ + ahead * ahead * pressure_slope2_);
  }
  // Of what all electrodes' rest values have in common besides, as a fingertip that warms up slows
  // down [counts^2].
  [[nodiscard]] double common_variance() const noexcept {
    const double left = since_ > 0 ? kSlows * Lead() * common_slope_ : 0;
    return left * left;
  }

 private:
  struct Moments {
    double sum = 0, timed = 0, squared = 0;  // of x, t x and x^2; t from now [samples]
  };
  struct Line {
    double level = 0, slope = 0;  // at the last sample taken [counts], [counts/sample]
  };

  static constexpr double kSpike = 20;  // from the line at most, lest one sample draws it [counts]
  static constexpr double kStandsOut = 2;  // times the slopes' variance
  static constexpr double kLasts = 100;    // a slope seen last, about [samples]
  static constexpr double kBends = 0.2;    // part of a slope that may have changed since
  static constexpr double kSlows = 0.5;    // likewise of what all have in common

  static double Signal(const FingerReading& reading, std::size_t i) noexcept {
    if (i < kElectrodeCount) return static_cast<double>(reading.electrodes[i]);
    return static_cast<double>(i == kElectrodeCount ? reading.pac : reading.pdc);
  }
  // How far the line goes on beyond the last sample taken [samples].
  [[nodiscard]] double Lead() const noexcept { return kLasts * -std::expm1(-since_ / kLasts); }

  // From squares of which a few may be of electrodes that do not work.
  static double VarianceOf(std::array<double, kElectrodeCount>& squares) noexcept {
    constexpr double kMedian = 0.455;  // of the square of a standard normal
    const auto middle = squares.begin() + kElectrodeCount / 2;
    std::ranges::nth_element(squares, middle);
    return *middle / kMedian;
  }

  void Fit() noexcept {
    const double middle = middle_ = time_ / weight_;
    const double spread = squared_time_ / weight_ - middle * middle;
    std::array<double, kElectrodeCount> slopes2, noise2;
    for (std::size_t i = 0; i < kSignalCount; ++i) {
      const Moments& m = moments_[i];
      const double mean = m.sum / weight_;
      lines_[i] = {mean, spread > 0 ? (m.timed / weight_ - middle * mean) / spread : 0};
      const double slope2 = lines_[i].slope * lines_[i].slope;
      const double left2 = std::max(0.0, m.squared / weight_ - mean * mean - slope2 * spread);
      if (i >= kElectrodeCount) {
        pressure_noise2_ = left2;  // the last one's
        continue;
      }
      slopes2[i] = slope2;
      noise2[i] = left2;
    }
    const double slope2 = VarianceOf(slopes2);
    const double slope_variance = spread > 0 ? VarianceOf(noise2) / (weight_ * spread) : 0;
    const double part = slope2 > 0 ? std::max(0.0, 1 - kStandsOut * slope_variance / slope2) : 0;
    lines_[kElectrodeCount].slope = 0;  // pac0 is a rate itself
    common_slope_ = 0;
    for (std::size_t i = 0; i < kSignalCount; ++i) {
      lines_[i].slope *= part;
      lines_[i].level -= middle * lines_[i].slope;
      if (i < kElectrodeCount) common_slope_ += lines_[i].slope / kElectrodeCount;
    }
    pressure_slope2_ = spread > 0 ? part * part / (weight_ * spread) : 0;
    slope_variance_ = part * slope_variance + kBends * kBends * part * part * slope2;
  }

  int wanted_;
  int taken_ = 0, since_ = 0;                        // samples, since the last one taken
  double weight_ = 0, time_ = 0, squared_time_ = 0;  // sums of 1, t and t^2
  double slope_variance_ = 0;                        // [counts^2/sample^2]
  double common_slope_ = 0;                          // mean of the electrodes' [counts/sample]
  double middle_ = 0;                                // of the samples' times, at the last one taken
  double pressure_noise2_ = 0, pressure_slope2_ = 0;  // [counts^2], times [1/sample^2]
  FingerReading origin_;
  std::array<Moments, kSignalCount> moments_{};
  std::array<Line, kSignalCount> lines_{};
};

}  // namespace palpate
