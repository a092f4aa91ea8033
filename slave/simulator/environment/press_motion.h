// Scripted motion: from rest to rest with minimum jerk (Flash & Hogan, J. Neurosci. 5, 1985).
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "slave/scene/scene.h"

namespace palpate {

// Returns the fraction of the distance after the fraction `u` of the time, 0 to 1; the peak speed
// is 15/8 of the mean.
inline double MinimumJerk(double u) noexcept {
  return u * u * u * (10 + u * (-15 + 6 * u));
}
inline constexpr double kMinimumJerkPeak = 15.0 / 8.0;

// Returns the fraction of the time after the fraction `way` of the distance, by bisection.
inline double InverseMinimumJerk(double way) noexcept {
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (MinimumJerk(middle) < way ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Contacts without an operator, repeated `presses` times: from home by the displacement `way` in a
// minimum-jerk ramp, a hold, the same ramp back and a rest.
struct PressMotion {
  Eigen::Vector3d home{0, 0, 0}, way{0, 0, 0};  // of the tip, frame S [m]
  int presses = 1;
  double start = 0;                     // of the first ramp [s]
  double ramp = 0, hold = 0, rest = 0;  // [s]

  [[nodiscard]] double period() const noexcept { return 2 * ramp + hold + rest; }
  [[nodiscard]] double duration() const noexcept { return start + presses * period(); }
  [[nodiscard]] double hold_begin() const noexcept { return start + ramp; }
  // The tip at `t` [s], frame S [m]; home before, after, and for NaN.
  [[nodiscard]] Eigen::Vector3d Tip(double t) const noexcept {
    return home + PartAt(t - start) * way;
  }

 private:
  [[nodiscard]] double PartAt(double t) const noexcept {
    if (!(t > 0 && t < presses * period())) return 0;
    const double in_press = std::fmod(t, period());
    if (in_press >= 2 * ramp + hold) return 0;
    const double back = in_press - ramp - hold;
    return MinimumJerk(back > 0 ? 1 - back / ramp : std::min(in_press / ramp, 1.0));
  }
};

// Largest speed of the scene's own contact: that of operator.press, or the manipulator's if that is
// less [m/s].
inline double PressSpeed(const Scene& scene) {
  return std::min(scene.operator_options.press_speed, scene.manipulator.max_speed);
}

}  // namespace palpate
