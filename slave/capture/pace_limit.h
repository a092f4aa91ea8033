// Limits the number of messages per second of a peer. Messages that the network delayed arrive all
// at once and are no flood: after a silence of up to kMaxStall all messages that could be sent in
// that time are allowed.
#pragma once

#include <algorithm>

#include "shared/state/clock.h"

namespace palpate {

// PaceLimit is not thread-safe.
class PaceLimit {
 public:
  static constexpr double kMaxStall = 30;  // a longer one ends the connection [s]

  // `max_rate`: largest number per second, and largest number of messages at once in the beginning.
  explicit PaceLimit(double max_rate) : max_rate_(max_rate), left_(max_rate) {}

  // Counts a message at `now`, which does not decrease; false: above the limit.
  bool Allows(Time now) noexcept {
    if (counted_at_ != Time{}) {
      const double gap = SecondsBetween(counted_at_, now);
      const double limit = max_rate_ * std::clamp(gap, 1.0, kMaxStall);
      left_ = std::max(left_, std::min(left_ + max_rate_ * gap, limit));
    }
    counted_at_ = now;
    return --left_ >= 0;
  }
  [[nodiscard]] double max_rate() const { return max_rate_; }

 private:
  double max_rate_, left_;  // messages per second, and messages that are allowed now
  Time counted_at_{};       // of the last message
};

}  // namespace palpate
