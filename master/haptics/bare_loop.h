// Three timer loops that do nothing, run beside the haptic loop under the same settings: what this
// machine would miss anyway. The haptic loop is judged against their median.
#pragma once

#include <array>
#include <cstdint>
#include <thread>

#include "master/haptics/periodic.h"

namespace palpate {

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
