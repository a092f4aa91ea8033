#include "shared/link/clock_offset.h"

#include <algorithm>
#include <cmath>

namespace palpate {

void ClockOffset::Add(Time t1, Time t2, Time t3, Time t4) noexcept {
  const double theta = 0.5 * (SecondsBetween(t1, t2) + SecondsBetween(t4, t3));
  const double delta = SecondsBetween(t1, t4) - SecondsBetween(t2, t3);
  if (!(delta >= 0)) return;
  // Two samples of the same clocks differ by at most their deltas. A clock that stood still while
  // its machine slept, or that was set, begins a new window.
  const bool is_far = known() && std::abs(theta - offset_) > delta + kLeap;
  far_ = is_far ? far_ + 1 : 0;
  if (far_ >= kLeapSamples) count_ = far_ = 0;
  samples_[count_ % kWindow] = {theta, delta, t4};
  ++count_;

  const auto aged_error = [t4](const Sample& s) {
    return s.delta / 2 + kDrift * SecondsBetween(s.at, t4);
  };
  const auto end = samples_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, kWindow));
  const Sample& best = *std::min_element(samples_.begin(), end, [&](const auto& a, const auto& b) {
    return aged_error(a) < aged_error(b);
  });
  const double step = best.theta - offset_;
  const double allowed =
      count_ <= kWindow ? std::abs(step) : kSlew * std::max(0.0, SecondsBetween(updated_at_, t4));
  offset_ += std::clamp(step, -allowed, allowed);
  error_ = aged_error(best) + std::abs(best.theta - offset_);
  updated_at_ = t4;
}

}  // namespace palpate
