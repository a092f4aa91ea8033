#include "slave/tactile/baseline.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

// Distance from the fitted line at which a sample is clipped, so that a single sample cannot change
// the line much [noise at rest].
constexpr double kSpike = 20;
// Smallest significant squared slope relative to the variance from noise: for all electrodes
// together, and for the pressure or a few channels [-].
constexpr double kTogether = 2, kAlone = 9;
// Typical time for which the last slope continues [samples].
constexpr double kLasts = 1000;
constexpr double kChanges = 0.01;       // sigma of the relative change of a slope per sample
constexpr double kRounding = 1.0 / 12;  // [noise^2] [derived: variance of rounding to whole counts]
// Time constants without contact: stationary, drifting [s].
constexpr double kFollowing = 2, kDrifting = 0.2;
// Limits of the smoothed changes that the baseline follows. If both are exceeded there is a
// contact.
constexpr double kSmoothing = 0.1;  // weight of a sample in the smoothed changes
constexpr double kElectrode = 1;    // [noise at rest]
constexpr double kPressure = 2;     // [counts]
constexpr double kMaxOfOne = 4;  // of one channel, so that a faulty one does not decide [noise^2]
double Signal(const FingerReading& reading, std::size_t i) noexcept {
  if (i < reading.channels.size()) return static_cast<double>(reading.channels[i]);
  return static_cast<double>(i == reading.channels.size() ? reading.pac : reading.pdc);
}

// Estimates a variance from squares, of which a few may belong to faulty electrodes.
double VarianceOf(std::span<double> squares) noexcept {
  constexpr double kMedian = 0.455;  // [-] [derived: median of the square of a standard normal]
  return MedianOf(squares) / kMedian;
}

// Returns the factor by which slopes are reduced if their mean square is `slope2`, of which
// `noise2` is noise.
double Shrinkage(double slope2, double noise2) noexcept {
  return slope2 > 0 ? std::max(0.0, 1 - noise2 / slope2) : 0;
}

}  // namespace

void Baseline::Advance() noexcept {
  tt_ += -2 * t_ + n_;
  t_ -= n_;
  for (Sums& sums : sums_) sums.tx -= sums.x;
  ++since_;
}

void Baseline::Take(const FingerReading& reading, double keep) noexcept {
  const bool is_fitted = known();
  if (taken_ == 0) origin_ = reading;
  ++taken_;
  since_ = 0;
  n_ = keep * n_ + 1;
  t_ *= keep;
  tt_ *= keep;
  const double spike = kSpike * sensor_.noise;
  for (std::size_t i = 0; i < signals(); ++i) {
    const double level = lines_[i].level;
    const double read = Signal(reading, i) - Signal(origin_, i);
    const double x = is_fitted ? std::clamp(read, level - spike, level + spike) : read;
    sums_[i] = {keep * sums_[i].x + x, keep * sums_[i].tx, keep * sums_[i].xx + x * x};
  }
  if (known()) Fit();
}

// A contact changes both electrodes and pressure; other changes are drift. Without a pressure a
// sudden change of the channels is a contact.
void Baseline::Follow(const FingerReading& reading) noexcept {
  const TactileSignals change = Change(reading);
  double channels = 0;
  for (std::size_t i = 0; i < change.size(); ++i) {
    clear_[i] += kSmoothing * (change[i] - clear_[i]);
    const double noises = clear_[i] / sensor_.noise;
    if (i < sensor_.channels) channels += std::min(noises * noises, kMaxOfOne);
  }
  const double pressure = clear_.back();
  const bool moves = channels > static_cast<double>(sensor_.channels) * kElectrode * kElectrode;
  if (moves && (pressure > kPressure || !sensor_.has_pressure)) return;
  const bool drifts = moves || std::abs(pressure) > kPressure;
  const double keep = std::exp(-1 / ((drifts ? kDrifting : kFollowing) * rate_));
  Take(reading, keep);
  for (double& average : clear_) average *= keep;
}

double Baseline::Ahead() const noexcept {
  return kLasts * -std::expm1(-since_ / kLasts);
}

TactileSignals Baseline::Change(const FingerReading& reading, double ago) const noexcept {
  TactileSignals change;
  change.resize(signals());
  const double t = since_ > 0 ? Ahead() : -ago;
  for (std::size_t i = 0; i < signals(); ++i) {
    const auto& [level, slope] = lines_[i];
    change[i] = Signal(reading, i) - Signal(origin_, i) - level - t * slope;
  }
  return change;
}

double Baseline::variance() const noexcept {
  return Ahead() * Ahead() * drift_variance_;
}

double Baseline::pressure_variance() const noexcept {
  const double ahead = Ahead() - middle_;
  return pressure_noise2_ * (1 / n_ + ahead * ahead * pressure_slope2_);
}

TactileSignals Baseline::drift_sigma() const noexcept {
  const double t = Ahead();
  TactileSignals sigma;
  sigma.resize(signals());
  for (std::size_t i = 0; i < signals(); ++i) sigma[i] = kChanges * t * t / 2 * lines_[i].slope;
  return sigma;
}

void Baseline::Fit() noexcept {
  middle_ = t_ / n_;
  const double spread = tt_ / n_ - middle_ * middle_;
  const double weight = spread > 0 ? 1 / (n_ * spread) : 0;  // variance of a slope over the noise's
  TactileSignals slopes, noise2, slopes2, residuals2;
  for (TactileSignals* each : {&slopes, &noise2}) each->resize(signals());
  for (TactileSignals* each : {&slopes2, &residuals2}) each->resize(sensor_.channels);
  for (std::size_t i = 0; i < signals(); ++i) {
    const Sums& sums = sums_[i];
    const double mean = sums.x / n_;
    slopes[i] = (sums.tx - middle_ * sums.x) * weight;
    noise2[i] = std::max(0.0, sums.xx / n_ - mean * mean - slopes[i] * slopes[i] * spread);
    if (i >= sensor_.channels) continue;
    slopes2[i] = slopes[i] * slopes[i];
    residuals2[i] = noise2[i];
  }
  spread_ = std::sqrt(*std::ranges::max_element(residuals2));
  const double electrode_noise2 =
      std::max(MedianOf(residuals2), kRounding * sensor_.noise * sensor_.noise);
  const double slope2 = VarianceOf(slopes2);
  // With few channels noise causes a significant slope more often than with many electrodes.
  const double least = sensor_.has_pressure ? kTogether : kAlone;
  const double together = Shrinkage(slope2, least * weight * electrode_noise2);
  drift_variance_ = together * weight * electrode_noise2;
  pressure_noise2_ = noise2.back();
  const double pressure =
      std::max(together, Shrinkage(slopes.back() * slopes.back(), kAlone * weight * noise2.back()));
  pressure_slope2_ = pressure * pressure * weight;
  for (std::size_t i = 0; i < signals(); ++i) {
    double used = i < sensor_.channels ? together : pressure;
    if (i == sensor_.channels) used = 0;  // pac0 is a rate itself
    lines_[i] = {sums_[i].x / n_ - middle_ * used * slopes[i], used * slopes[i]};
  }
}

}  // namespace palpate
