// Limits the number of messages per second of a peer.
#pragma once

#include "shared/state/clock.h"

namespace palpate {

// Not thread-safe.
class PaceLimit {
 public:
  // `most`: largest number per second.
  explicit PaceLimit(double most) : most_(most) {}

  // Counts a message at `now`; false: above the limit.
  bool Allows(Time now) noexcept {
    if (SecondsBetween(began_, now) > 1) {
      began_ = now;
      count_ = 0;
    }
    return ++count_ <= most_;
  }
  [[nodiscard]] double most() const { return most_; }

 private:
  double most_, count_ = 0;
  Time began_{};  // start of the current second
};

}  // namespace palpate
