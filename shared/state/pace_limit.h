// How much a peer may send: so many things within a second, and what is more is refused.
#pragma once

#include "shared/state/clock.h"

namespace palpate {

// Not thread-safe.
class PaceLimit {
 public:
  // `most`: within a second.
  explicit PaceLimit(double most) : most_(most) {}

  // Counts one more that came at `now`; false: one too many.
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
  Time began_{};  // the second that counts
};

}  // namespace palpate
