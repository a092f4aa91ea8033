// What the verdicts of `verify` compare: means of loads, mean errors and scales with intervals.
#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/commands/verify/force_card.h"

namespace palpate {

std::map<int, std::vector<const MatchedState*>> ByLoad(
    const std::vector<const MatchedState*>& states);

// Means of `known(state)` and `reported(state)`, and of the stated deviation, over `states`.
template <class Known, class Reported>
KnownAndReported MeanOf(const std::vector<const MatchedState*>& states, const Known& known,
                        const Reported& reported) {
  KnownAndReported mean;
  const double share = 1 / static_cast<double>(states.size());
  for (const MatchedState* one : states) {
    mean.known += share * known(*one);
    mean.reported += share * reported(*one);
    mean.sigma += share * std::hypot(one->state.sigma, one->known.sigma_or_usual());
  }
  return mean;
}

// Size of the mean of neighbouring errors: from the spread of the means of ten parts or fewer.
// nullopt: fewer than three errors.
std::optional<std::pair<Eigen::Vector3d, Interval>> MeanError(
    const std::vector<Eigen::Vector3d>& errors);

// 1 / interval; an upper end without bound where the interval reaches zero.
Interval Inverse(const Interval& interval);

// Two ends of what a scale may be: see RecordMap.
struct Scale {
  Interval forth, back;

  [[nodiscard]] Interval Both() const;
  [[nodiscard]] Finding Judge(double tolerance) const;
};

}  // namespace palpate
