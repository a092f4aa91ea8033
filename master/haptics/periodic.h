// Loops on absolute deadlines, and what the operating system can do for it.
#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <string>
#include <thread>

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

// Calls `tick()` each millisecond for `length`, until `stop` is asked for or `tick` returns false.
// Late: once, with what time it is, and what was missed is skipped and counted. `tick` must not
// throw.
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

// For the process: what memory it touches stays. In words why not; empty: done.
std::string LockMemory();

// Three timer loops that do nothing, run beside the haptic loop under the same settings: what this
// machine would miss anyway. The haptic loop is judged against their median.
class BareLoops {
 public:
  static constexpr std::size_t kCount = 3;
  // Starts them; they end after `length` or with Stop.
  BareLoops(Clock::duration length, int priority);
  // Ends and joins them. Idempotent.
  void Stop();
  // Missed periods of each, sorted. After Stop.
  [[nodiscard]] std::array<std::uint64_t, kCount> missed() const;

 private:
  std::array<PeriodicStats, kCount> stats_;
  std::array<std::jthread, kCount> threads_;  // last: they use stats_
};

}  // namespace palpate
