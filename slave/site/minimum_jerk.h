// Motion from rest to rest with the least jerk (Flash & Hogan, J. Neurosci. 5, 1985).
#pragma once

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

}  // namespace palpate
