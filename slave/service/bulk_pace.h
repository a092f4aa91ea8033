// Rate limit for images and meshes while an operator is connected: as much as the link carries
// without a queue that would delay the operator's states.
#pragma once

#include <algorithm>
#include <limits>
#include <mutex>
#include <string>
#include <utility>

#include "shared/link/clock_offset.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"

namespace palpate {

// Delay-based, like LEDBAT (RFC 6817), but with the operator's round-trip time instead of that of
// the limited streams. It also detects queues in a relay, and ignores queues that do not delay the
// operator. The streams together keep at least `kMinRate`. Thread-safe.
class BulkPace {
 public:
  static constexpr double kUnbound = std::numeric_limits<double>::infinity();
  // Rate of all streams together [bytes/s]; also the initial rate, so that the base round-trip time
  // is measured.
  static constexpr double kMinRate = 128e3;
  static constexpr double kPeriod = 0.05;  // time of a decision, or the round-trip time [s]

  // Reports a round-trip time of the operator at `peer` [s].
  void AddRoundTrip(const std::string& peer, double round_trip) {
    const std::scoped_lock lock(mutex_);
    if (peer != std::exchange(peer_, peer)) Restart();
    if (round_trip >= 0) shortest_ = std::min(shortest_, round_trip);  // skips NaN, too
  }
  // Whether a stream may send a message at `now`. It is counted with its `expected` size [bytes].
  bool Begin(double expected, Time now) {
    const std::scoped_lock lock(mutex_);
    const double dt = std::max(0.0, SecondsBetween(settled_, now));
    settled_ = std::max(settled_, now);
    Update(dt);
    debt_ = rate_ == kUnbound ? 0 : std::max(-rate_ * kBurst, debt_ - rate_ * dt);
    if (debt_ > 0) return false;
    Count(expected);
    return true;
  }
  // The message that was begun had `actual` bytes; 0: it was not sent.
  void End(double expected, double actual) {
    const std::scoped_lock lock(mutex_);
    Count(actual - expected);
  }

 private:
  static constexpr double kMaxQueueing =
      3e-3;  // queueing time of the shortest trip of a period [s]
  static constexpr double kMaxVariation = 0.1;  // jitter, relative to the base round-trip time [-]
  static constexpr double kMore = 1.05, kLess = 0.85;
  static constexpr double kSilence = 5;   // time without an operator [s]
  static constexpr double kBurst = 5e-3;  // largest burst of the streams [s at their rate]

  void Restart() {
    rate_ = shortest_ = kUnbound;
    since_ = sent_ = 0;
    own_ = {};
  }
  void Count(double bytes) {
    debt_ += bytes;
    sent_ += bytes;
  }
  // Decides the rate limit, `dt` [s] after the last call.
  void Update(double dt) {
    since_ += dt;
    if (since_ > kSilence) Restart();
    if (shortest_ == kUnbound || since_ < std::max(kPeriod, own_.OrZero())) return;
    own_.Learn(shortest_, since_);
    const double used = std::exchange(sent_, 0) / std::exchange(since_, 0);
    const bool waits = own_.Waits(std::exchange(shortest_, kUnbound), kMaxQueueing, kMaxVariation);
    if (rate_ == kUnbound) {
      rate_ = kMinRate;
    } else if (waits && used > kMinRate) {
      rate_ = std::max(kMinRate, kLess * std::min(rate_, used));
    } else if (!waits && (used > rate_ / 2 || debt_ > 0)) {  // large messages are rare
      rate_ *= kMore;
    }
  }

  PriorityInheritanceMutex mutex_;  // guards the members below
  std::string peer_;                // the newest operator
  double rate_ = kUnbound;          // of all streams together [bytes/s]; kUnbound: no operator
  double debt_ = 0;                 // sent, and not yet due at this rate [bytes]
  double since_ = 0, sent_ = 0, shortest_ = kUnbound;  // of this period
  BaseRoundTrip own_;
  Time settled_{};
};

}  // namespace palpate
