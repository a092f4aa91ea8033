// Time of the haptic loop: since its first tick, and between two ticks.
#pragma once

#include <algorithm>
#include <optional>

#include "master/haptics/periodic.h"
#include "shared/state/clock.h"

namespace palpate {

class TickClock {
 public:
  // Begins a tick. Time since the last one, within bounds [s].
  double Tick(Time now) noexcept {
    if (!origin_) origin_ = now, last_ = now - kHapticPeriod;
    const double dt = SecondsBetween(last_, now);
    last_ = now;
    return std::clamp(dt, kShortest, kLongest);
  }
  // Since the first tick [s].
  [[nodiscard]] double ToSeconds(Time t) const noexcept {
    return SecondsBetween(origin_.value_or(Time{}), t);
  }

 private:
  static constexpr double kShortest = 1e-6, kLongest = 0.1;  // [s]

  std::optional<Time> origin_;
  Time last_{};
};

}  // namespace palpate
