// A clock that the drivers of a slave advance, in place of the machine's.
#pragma once

#include "shared/state/clock.h"

namespace palpate {

// While an object exists, Clock::now() in its thread returns the newest time that was reached.
// Waiting for a time there only advances this clock. It begins at the same date in each process, so
// that equal samples give identical results.
class DrivenClock {
 public:
  static constexpr Time kBegin{std::chrono::hours(24 * 10957)};  // 2000-01-01

  DrivenClock() noexcept;
  ~DrivenClock();
  DrivenClock(const DrivenClock&) = delete;
  DrivenClock& operator=(const DrivenClock&) = delete;

  // Returns whether this thread has one.
  static bool is_active() noexcept;
  // Sets the clock of this thread to `t` unless it is later already. Returns false if the thread
  // has no driven clock.
  static bool Reach(Time t) noexcept;

 private:
  Time now_ = kBegin;
  Time* const former_;  // of this thread; null: the machine's clock
};

}  // namespace palpate
