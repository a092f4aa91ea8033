// Maps timestamps of a sender of samples to the own clock.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "shared/state/clock.h"

namespace palpate {

// Estimates the clock offset from one-way delays. A sample cannot arrive before it is taken, so the
// smallest difference of the two clocks is closest to their offset. It expires after ten to twenty
// seconds, because clocks drift.
class SenderClock {
 public:
  // Maps the timestamp `sent` of a sample that arrived at `at`. The result is `at` or earlier.
  Time Map(Time sent, Time at) noexcept {
    const Clock::duration offset = at - sent;
    if (!since_ || at - *since_ > kBucket) {
      before_ = since_ ? now_ : offset;
      now_ = offset;
      since_ = at;
    }
    now_ = std::min(now_, offset);
    return sent + std::min(now_, before_);
  }
  void Reset() noexcept { since_.reset(); }

 private:
  static constexpr Clock::duration kBucket = std::chrono::seconds(10);

  std::optional<Time> since_;         // when `now_` began
  Clock::duration now_{}, before_{};  // smallest differences, this and the last bucket
};

}  // namespace palpate
