// How fast pictures and meshes may go while somebody operates: as fast as the line takes them
// without a queue, which the operator's states would wait in.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

#include "shared/link/base_round_trip.h"

namespace palpate {

// Delay-based, as LEDBAT (RFC 6817) is, but by the operator's round trips, not by those of the
// connections that are paced: a queue counts in a relay, too, and one that the operator does not
// wait in costs nobody anything. What else fills the line has it: watchers keep `kLeast`.
class BulkPace {
 public:
  static constexpr double kUnbound = std::numeric_limits<double>::infinity();
  // Of all watchers together [bytes/s]; first, too, so that the line's own round trip is seen.
  static constexpr double kLeast = 128e3;
  static constexpr double kPeriod = 0.05;  // of a decision, or the line's round trip [s]

  // A state's way to the operator and back took so long [s].
  void Hear(double round_trip) {
    if (round_trip >= 0) shortest_ = std::min(shortest_, round_trip);  // nor NaN
  }
  // What all watchers together may send [bytes/s], `dt` [s] after the last time, since when `sent`
  // [bytes] of theirs were acknowledged. kUnbound: nobody operates.
  double Update(double sent, double dt) {
    since_ += dt;
    sent_ += sent;
    if (since_ > kSilence) *this = {};
    if (shortest_ == kUnbound || since_ < std::max(kPeriod, own_.OrZero())) return rate_;
    own_.Learn(shortest_, since_);
    const double used = std::exchange(sent_, 0) / std::exchange(since_, 0);
    const bool waits = own_.Waits(std::exchange(shortest_, kUnbound), kStanding, kShaken);
    if (rate_ == kUnbound) {
      rate_ = kLeast;
    } else if (waits && used > kLeast) {
      rate_ = std::max(kLeast, kLess * std::min(rate_, used));
    } else if (!waits && used > rate_ / 2) {
      rate_ *= kMore;
    }
    return rate_;
  }

 private:
  static constexpr double kStanding = 3e-3;  // that the shortest trip of a period waited [s]
  static constexpr double kShaken = 0.1;     // of a line's own round trip, by itself
  static constexpr double kMore = 1.05, kLess = 0.85;
  static constexpr double kSilence = 5;  // nobody operates [s]

  double rate_ = kUnbound;
  double since_ = 0, sent_ = 0, shortest_ = kUnbound;  // of this period
  BaseRoundTrip own_;
};

}  // namespace palpate
