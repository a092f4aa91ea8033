// Scripted motion: from rest to rest with minimum jerk (Flash & Hogan, J. Neurosci. 5, 1985).
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "slave/scene/scene.h"

namespace palpate {

// Part of the way gone after part `u` of the time, 0 to 1; the peak speed is 15/8 of the mean.
inline double MinimumJerk(double u) noexcept {
  return u * u * u * (10 + u * (-15 + 6 * u));
}
inline constexpr double kMinimumJerkPeak = 15.0 / 8.0;

// Part of the time after which part `way` has been gone: the ramp rises, so halving finds it.
inline double InverseMinimumJerk(double way) noexcept {
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (MinimumJerk(middle) < way ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// A sequence of contacts, each a ramp in, a hold, the same ramp back and a rest [s].
struct PressMotion {
  int presses = 1;
  double ramp = 0, hold = 0, rest = 0;

  [[nodiscard]] double period() const noexcept { return 2 * ramp + hold + rest; }
  [[nodiscard]] double duration() const noexcept { return presses * period(); }
  // Part of the way in that is gone at `t` [s] after the start; 0 before, after, and for NaN.
  [[nodiscard]] double At(double t) const noexcept {
    if (!(t > 0 && t < duration())) return 0;
    const double in_press = std::fmod(t, period());
    if (in_press >= 2 * ramp + hold) return 0;
    const double back = in_press - ramp - hold;
    return MinimumJerk(back > 0 ? 1 - back / ramp : std::min(in_press / ramp, 1.0));
  }
};

// The scene's own contact. Throws std::invalid_argument naming the key.
struct PressRequest {
  double depth = 0;  // beyond the first touch [m]
  double speed =
      0;  // largest speed: that of operator.press, or the manipulator's if that is less [m/s]

  explicit PressRequest(const Scene& scene) {
    const auto positive = [](double value, const char* key, const char* unit) {
      if (value > 0 && std::isfinite(value)) return value;
      throw std::invalid_argument(fmt::format("{} = {:g} {}: accepted is > 0", key, value, unit));
    };
    depth = positive(scene.operator_options.press_depth, "operator.press.depth", "m");
    speed = std::min(positive(scene.operator_options.press_speed, "operator.press.speed", "m/s"),
                     positive(scene.manipulator.max_speed, "manipulator.max_speed", "m/s"));
  }
};

}  // namespace palpate
