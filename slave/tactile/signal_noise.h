// The noise of a fingertip's signals, as it is measured from sample to sample.
#pragma once

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Noise is what each signal, or its distance from what is expected, does from sample to sample,
// whichever does less: a contact that begins is none, nor is another kind that explains it.
// Allocation-free.
class SignalNoise {
 public:
  using Signals = SignalPattern::Signals;
  // In which the mean noise is measured [s].
  static constexpr double kMeasuringTime = 0.3;

  // `rate` of the samples [Hz], > 0.
  explicit SignalNoise(double rate);
  void Reset() noexcept;
  // Processes the next sample, and its distances `off` from what is expected. `is_known`:
  // electrodes whose last three samples tell of noise.
  void Take(const Signals& x, const Signals& off, const Electrodes& is_known) noexcept;

  // Variance of each signal, at least the usual one [counts^2].
  [[nodiscard]] Signals variances() const noexcept;
  // Of the electrodes, over the usual one.
  [[nodiscard]] double relative() const { return noise_; }
  // The same relative to that of the first samples.
  [[nodiscard]] double since_start() const { return noise_ / first_noise_; }
  // Uncertainty of the gains, common or individual, one sigma [-].
  [[nodiscard]] double gain_sigma() const noexcept;

 private:
  // How much the electrodes' noise differs from electrode to electrode: of its logarithm, as one
  // sigma, by the median; a few that do not work do not count. 0: not known yet.
  [[nodiscard]] double Unevenness() const noexcept;

  double share_, level_share_;  // weight of a sample in time averages
  Signals noise2_, x_, before_x_, off_, before_off_;
  double level2_ = 0;  // of second differences of all electrodes [counts^2]
  Signals levels2_;    // the same of each signal by itself [counts^2]
  int seen_ = 0;
  double noise_ = 1, first_noise_ = 1;
};

}  // namespace palpate
