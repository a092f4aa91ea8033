// Correlation of the signals of one make of fingertip, for all contacts.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/signals/tactile_signals.h"

namespace palpate {

// E1 to E19 and pdc; pac0 is the rate of pdc and depends on the past.
inline constexpr int kPatternSignals = kElectrodeCount + 1;

// Error of a network's forces on contacts outside of its training: 68 % of the error vectors are at
// most sqrt(growing |f| + relative^2 |f|^2). Both 0: unknown.
struct ForceErrorLaw {
  double growing = 0;   // [N]
  double relative = 0;  // [-]

  [[nodiscard]] bool known() const noexcept { return growing > 0 || relative > 0; }
  // Returns the standard deviation of a force of this size, one sigma [N].
  [[nodiscard]] double At(double size) const noexcept {
    return std::sqrt(growing * size + relative * relative * size * size);
  }
};

// Learnt with a network, from the same contacts.
struct SignalPattern {
  using Signals = Eigen::Matrix<double, kPatternSignals, 1>;  // counts minus rest
  using Covariance = Eigen::Matrix<double, kPatternSignals, kPatternSignals>;
  // A kind of similar contacts.
  struct Kind {
    double share = 0;  // of all contacts [-], > 0
    Covariance shape;  // mean of x x' / x'x over their signals x [-], positive definite
    ForceErrorLaw error = {};
  };
  std::vector<Kind> kinds;
  // Force of small signals, least squares of the relative error [N/count].
  Eigen::Matrix<double, 3, kPatternSignals> force =
      Eigen::Matrix<double, 3, kPatternSignals>::Zero();

  [[nodiscard]] bool known() const { return !kinds.empty(); }
};

// Electrodes has one flag per electrode.
using Electrodes = std::array<bool, kElectrodeCount>;

inline SignalPattern::Signals PatternSignals(const TactileSignals& change) noexcept {
  SignalPattern::Signals x;
  for (int i = 0; i < kElectrodeCount; ++i) x[i] = change[static_cast<std::size_t>(i)];
  x[kElectrodeCount] = change[kElectrodeCount + 1];
  return x;
}

// Variance of sample-to-sample changes without contact: five real fingers [counts^2].
inline SignalPattern::Signals UsualNoise2() noexcept {
  SignalPattern::Signals noise2 = SignalPattern::Signals::Constant(0.85);
  noise2[kElectrodeCount] = 1.6;
  return noise2;
}

}  // namespace palpate
