// The noise of a fingertip's signals, measured from sample to sample.
#pragma once

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// SignalNoise estimates noise from the smaller of the second differences of each signal and of its
// residual, so that neither the beginning of a contact nor changes that the contact model explains
// count as noise. Allocation-free.
class SignalNoise {
 public:
  using Signals = SignalPattern::Signals;
  // Time in which the mean noise is measured [s].
  static constexpr double kMeasuringTime = 0.3;

  // `rate` of the samples [Hz], > 0.
  explicit SignalNoise(double rate);
  void Reset() noexcept;
  // Processes the next sample and its residuals. `is_known`:
  // electrodes whose last three samples show noise.
  void Update(const Signals& x, const Signals& residual, const Electrodes& is_known) noexcept;

  // Variance of each signal, at least that of an undisturbed sensor [counts^2].
  [[nodiscard]] Signals variances() const noexcept;
  // Returns the standard deviation of the electrodes, over that of an undisturbed
  // sensor [-].
  [[nodiscard]] double relative() const { return relative_; }
  // Returns the mean noise relative to that of the first samples.
  [[nodiscard]] double since_start() const { return relative_ / first_; }
  // Returns the uncertainty of the electrodes' gain, which affects noise and signals equally: one
  // sigma [-].
  [[nodiscard]] double gain_sigma() const noexcept;

 private:
  static constexpr int kCalm =
      3;  // samples without a fault, of a second difference [by definition]

  double share_;  // weight of a sample in time averages
  // noise2_: squares of second differences [counts^2]
  Signals noise2_, x_, before_x_, residual_, before_residual_;
  double mean2_ = 0;  // mean of noise2_ over the electrodes [counts^2]
  int seen_ = 0;
  double relative_ = 1, first_ = 1;
};

}  // namespace palpate
