// Base round trip of a link, without queueing: the shortest of the last 10 to 20 s.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

namespace palpate {

class BaseRoundTrip {
 public:
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();

  // Adds the shortest round trip of the last `period` [s]; kUnknown: there was none.
  void Learn(double shortest, double period) noexcept {
    newest_ = std::min(newest_, shortest);
    own_ = std::min(newest_, before_);
    remembered_ += period;
    if (remembered_ < kRemembered) return;
    remembered_ = 0;
    before_ = std::exchange(newest_, kUnknown);
  }
  // Whether packets are queued: `shortest` exceeds the base by `standing` [s] plus `share` of the
  // base.
  [[nodiscard]] bool Waits(double shortest, double standing, double share) const noexcept {
    return shortest < kUnknown && shortest > own_ + standing + share * own_;
  }
  [[nodiscard]] double OrZero() const noexcept { return own_ < kUnknown ? own_ : 0; }  // [s]

 private:
  static constexpr double kRemembered = 10;  // [s]; two periods are kept, because links change
  double own_ = kUnknown, newest_ = kUnknown, before_ = kUnknown, remembered_ = 0;
};

}  // namespace palpate
