// Electrodes whose signal jumps between two samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Detects an electrode that changes by far more than all others between two samples. A contact
// changes neighbours as well, so such an electrode has lost its connection or was exchanged for
// another. It is excluded until it has returned, or has agreed with its prediction for a while.
// Allocation-free.
class ElectrodeJumps {
 public:
  using Signals = SignalPattern::Signals;
  // Variance of an excluded electrode [counts^2].
  static constexpr double kUnknown2 = 1e6;

  void Reset() noexcept { *this = {}; }
  // Processes the next sample; `noise` of the electrodes, over the usual one.
  void Update(const Signals& x, double noise) noexcept {
    if (known_) FindJumps(x, noise);
    for (std::size_t i = 0; i < jumped_.size(); ++i) calm_[i] = is_out(i) ? 0 : calm_[i] + 1;
    last_ = x;
    known_ = true;
  }
  // `alive`: x without the excluded electrodes, to which `inverse` belongs.
  void Reinstate(const Signals& x, const Signals& alive,
                 const SignalPattern::Covariance& inverse) noexcept {
    const Signals y = inverse * alive;
    for (std::size_t i = 0; i < jumped_.size(); ++i) {
      if (!is_out(i)) continue;
      const auto k = static_cast<Eigen::Index>(i);
      const double error = x[k] - alive[k] + y[k] / inverse(k, k);
      const double variance = std::max(1 / inverse(k, k) - kUnknown2, UsualNoise2()[0]);
      const bool agrees = error * error < kAsExpected * kAsExpected * variance;
      agrees_[i] = agrees ? agrees_[i] + 1 : 0;
      if (agrees_[i] >= kReinstated) jumped_[i] = 0;
    }
  }
  [[nodiscard]] bool is_out(std::size_t electrode) const { return jumped_[electrode] != 0; }
  // Returns the electrodes that did not jump in the last three samples.
  [[nodiscard]] Electrodes calm() const noexcept {
    Electrodes calm{};
    std::ranges::transform(calm_, calm.begin(), [](int samples) { return samples >= 3; });
    return calm;
  }

 private:
  // Smallest jump relative to the change of the other electrodes between samples [-]. [tuned:
  // SignalsThatChangeTogetherAreUnchanged]
  static constexpr double kJump = 8;
  static constexpr double kBack = 0.3;  // remaining part of a jump that was only a spike
  // Largest deviation [sigma] of a reinstated electrode, during kReinstated samples.
  static constexpr double kAsExpected = 1.5;
  static constexpr int kReinstated = 20;

  void FindJumps(const Signals& x, double noise) noexcept {
    std::array<double, kElectrodeCount> moved;
    Eigen::Map<Eigen::Array<double, kElectrodeCount, 1>>(moved.data()) =
        (x - last_).head<kElectrodeCount>().cwiseAbs();
    std::array<double, kElectrodeCount> sorted = moved;
    std::ranges::sort(sorted);
    // Typical change of the other electrodes; a quarter of all may jump at once.
    const double usual = std::max(sorted[kElectrodeCount * 3 / 4], noise);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      if (moved[i] < kJump * usual) continue;
      const auto k = static_cast<Eigen::Index>(i);
      const double jump = x[k] - last_[k];
      const bool is_back = std::abs(jumped_[i] + jump) < kBack * std::abs(jump);
      jumped_[i] = is_back ? 0 : jump;
      agrees_[i] = 0;
    }
  }

  Signals last_ = Signals::Zero();
  bool known_ = false;                            // the last sample
  std::array<double, kElectrodeCount> jumped_{};  // size of the jump [counts]; 0: no jump
  std::array<int, kElectrodeCount> agrees_{};  // number of samples that agree with the prediction
  std::array<int, kElectrodeCount> calm_{};    // samples since it jumped, or was back
};

}  // namespace palpate
