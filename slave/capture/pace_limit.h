// Limits the number of messages per second of a peer. Messages that the network held up arrive all
// at once and are no flood: after a silence of up to kMaxStall all that could be sent in it is
// allowed.
#pragma once

#include <algorithm>

#include "shared/state/clock.h"

namespace palpate {

// PaceLimit is not thread-safe.
class PaceLimit {
 public:
  static constexpr double kMaxStall = 30;  // a longer one ends the connection [s]

  // `most`: largest number per second, and at once in the beginning.
  explicit PaceLimit(double most) : most_(most), left_(most) {}

  // Counts a message at `now`, which does not decrease; false: above the limit.
  bool Allows(Time now) noexcept {
    if (counted_at_ != Time{}) {
      const double gap = SecondsBetween(counted_at_, now);
      const double limit = most_ * std::clamp(gap, 1.0, kMaxStall);
      left_ = std::max(left_, std::min(left_ + most_ * gap, limit));
    }
    counted_at_ = now;
    return --left_ >= 0;
  }
  [[nodiscard]] double most() const { return most_; }

 private:
  double most_, left_;  // messages per second, and messages that are allowed now
  Time counted_at_{};   // of the last message
};

}  // namespace palpate
