// One clock per process: monotonic, and anchored to the wall clock once at start so that its stamps
// read as dates. It never steps. Two processes' clocks differ; shared/link estimates by how much.
#pragma once

#include <chrono>

namespace palpate {

struct Clock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<Clock>;
  static constexpr bool is_steady = true;

  // Now. Real-time safe.
  static time_point now() noexcept;
  // The same instant for waiting with `sleep_until` on the steady clock.
  static std::chrono::steady_clock::time_point ToSteady(time_point t) noexcept;
};

using Time = Clock::time_point;

// Seconds from `from` to `to` [s].
inline double SecondsBetween(Time from, Time to) noexcept {
  return std::chrono::duration<double>(to - from).count();
}
// `seconds` [s] as a duration of the clock, rounded towards zero. |seconds| < 9e9.
inline Clock::duration Seconds(double seconds) noexcept {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace palpate
