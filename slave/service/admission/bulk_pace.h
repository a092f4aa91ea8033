// Rate limit for images and meshes while an operator is connected: as much as the link carries
// without a queue that would delay the operator's states.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

#include "shared/link/base_round_trip.h"

namespace palpate {

// Delay-based, like LEDBAT (RFC 6817), but with the operator's round-trip time instead of that of
// the limited connections. It also detects queues in a relay, and ignores queues that do not delay
// the operator. Watchers keep at least `kLeast`.
class BulkPace {
 public:
  static constexpr double kUnbound = std::numeric_limits<double>::infinity();
  // Rate of all watchers together [bytes/s]; also the initial rate, so that the base round-trip
  // time is measured.
  static constexpr double kLeast = 128e3;
  static constexpr double kPeriod = 0.05;  // time of a decision, or the round-trip time [s]

  // Reports a round-trip time of the operator [s].
  void Hear(double round_trip) {
    if (round_trip >= 0) shortest_ = std::min(shortest_, round_trip);  // nor NaN
  }
  // Rate limit of all watchers together [bytes/s]. `dt` [s]: time since the last call, in which
  // `sent` [bytes] were acknowledged. kUnbound: no operator.
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
  static constexpr double kShaken = 0.1;     // base round-trip time of the link
  static constexpr double kMore = 1.05, kLess = 0.85;
  static constexpr double kSilence = 5;  // time without an operator [s]

  double rate_ = kUnbound;
  double since_ = 0, sent_ = 0, shortest_ = kUnbound;  // of this period
  BaseRoundTrip own_;
};

}  // namespace palpate
