// Which kind of contact explains the signals of a fingertip best.
#pragma once

#include <cstddef>
#include <vector>

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// See PatternCheck for S. Immutable.
class ContactKinds {
 public:
  using Signals = SignalPattern::Signals;
  using Covariance = SignalPattern::Covariance;
  // Standard deviations from what is expected, beyond which a signal is wrong. [-] [tuned:
  // AnElectrodeThatStandsStillNeedsLessToBeWrong]
  static constexpr double kOutlier = 5.5;

  struct Explanation {
    std::size_t kind = 0;  // in SignalPattern::kinds
    double cost = 0;
    Covariance inverse;  // of S [1/counts^2]
  };

  // The pattern must be known.
  explicit ContactKinds(const SignalPattern& pattern);
  // Signals `x` of squared size `size2`, one of which may be wrong; N is the diagonal `noise2`, and
  // `drift` the rest of S [counts^2]. Allocation-free.
  [[nodiscard]] Explanation Explain(const Signals& x, const Signals& noise2,
                                    const Covariance& drift, double size2) const noexcept;

 private:
  struct Kind {
    double share = 0;
    Covariance shape;
    // At a typical size: selects the kinds to evaluate.
    Covariance inverse;
    double offset = 0;
  };
  std::vector<Kind> kinds_;
};

}  // namespace palpate
