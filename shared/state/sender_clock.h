// The clock of whoever pushes samples, on ours.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "shared/state/clock.h"

namespace palpate {

// A sender's clock on ours, from one-way delays alone. A sample cannot arrive before it was taken,
// so the smallest difference of the two clocks lies closest to their offset. It is forgotten after
// ten to twenty seconds, so that clocks may drift.
class SenderClock {
 public:
  // A stamp `sent` of the sender's clock arrived `at` ours; the stamp on our clock, `at` or
  // earlier.
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
