// The clock of a process: monotonic, and aligned with the wall clock once at the start, so that its
// timestamps are dates. It never steps. shared/link estimates the offset between two processes.
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
  // Converts a time to the steady clock, for `sleep_until`.
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
