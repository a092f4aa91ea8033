// Loops with absolute deadlines, and real-time settings of the operating system.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "shared/state/clock.h"
#include "shared/telemetry/latency_histogram.h"

namespace palpate {

inline constexpr Clock::duration kHapticPeriod = std::chrono::milliseconds(1);

struct PeriodicStats {
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;  // periods that passed without a tick
  double duration = 0;       // from the first deadline to the last, (ticks + missed) periods [s]
  LatencyHistogram wake_us;  // how late each tick woke [us]
};

// Waits for `deadline` on the monotonic clock. Real-time safe.
void WaitUntil(Time deadline) noexcept;

// Calls `tick()` each millisecond for `length`, until `stop` is requested or `tick` returns false.
// After a late wake-up it calls `tick` once, and skips and counts the missed periods. `tick` must
// not throw.
template <class Tick>
void RunPeriodically(Clock::duration length, const std::stop_token& stop, PeriodicStats* stats,
                     Tick&& tick) noexcept {
  const Time begin = Clock::now();
  Time wake = begin;
  bool wanted = true;
  while (wanted && !stop.stop_requested() && wake < begin + length) {
    WaitUntil(wake);
    stats->wake_us.Add(SecondsBetween(wake, Clock::now()) * 1e6);
    wanted = tick();
    ++stats->ticks;
    const auto lost = (Clock::now() - wake) / kHapticPeriod;
    stats->missed += static_cast<std::uint64_t>(lost);
    wake += (lost + 1) * kHapticPeriod;
  }
  stats->duration = SecondsBetween(begin, wake);
}

// Locks the memory of the process. Returns the reason if that fails, else an empty string.
std::string LockMemory();

// Time of the haptic loop: since its first tick, and between two ticks.
class TickClock {
 public:
  // Begins a tick. Time since the last one, within bounds [s].
  double Tick(Time now) noexcept {
    if (!origin_) origin_ = now, last_ = now - kHapticPeriod;
    const double dt = SecondsBetween(last_, now);
    last_ = now;
    return std::clamp(dt, kMinPeriod, kMaxPeriod);
  }
  // Since the first tick [s].
  [[nodiscard]] double ToSeconds(Time t) const noexcept {
    return SecondsBetween(origin_.value_or(Time{}), t);
  }

 private:
  static constexpr double kMinPeriod = 1e-6, kMaxPeriod = 0.1;  // [s]

  std::optional<Time> origin_;
  Time last_{};
};

}  // namespace palpate
