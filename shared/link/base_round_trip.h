// A line's own round trip, with nothing waiting in it: the shortest of the last while.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

namespace palpate {

class BaseRoundTrip {
 public:
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();

  // The shortest of the last `period` [s]; kUnknown: there was none.
  void Learn(double shortest, double period) noexcept {
    newest_ = std::min(newest_, shortest);
    own_ = std::min(newest_, before_);
    remembered_ += period;
    if (remembered_ < kRemembered) return;
    remembered_ = 0;
    before_ = std::exchange(newest_, kUnknown);
  }
  // Whether trips wait, the shortest of which is longer by `standing` [s] and a share of its own.
  [[nodiscard]] bool Waits(double shortest, double standing, double share) const noexcept {
    return shortest < kUnknown && shortest > own_ + standing + share * own_;
  }
  [[nodiscard]] double OrZero() const noexcept { return own_ < kUnknown ? own_ : 0; }  // [s]

 private:
  static constexpr double kRemembered = 10;  // [s], twice: lines change
  double own_ = kUnknown, newest_ = kUnknown, before_ = kUnknown, remembered_ = 0;
};

}  // namespace palpate
