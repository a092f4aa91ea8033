// How fast pictures and meshes may go while somebody operates: as fast as the line takes them
// without a queue, which the operator's states would wait in.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

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
    if (shortest_ == kUnbound || since_ < std::max(kPeriod, own_)) return rate_;
    LearnOwn();
    const double used = std::exchange(sent_, 0) / std::exchange(since_, 0);
    const bool waits = std::exchange(shortest_, kUnbound) > own_ + kStanding + kShaken * own_;
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
  static constexpr double kRemembered = 10;  // [s], twice: lines change
  static constexpr double kSilence = 5;      // nobody operates [s]

  // The line's own round trip: the shortest of the last while, since the pace empties the queue.
  void LearnOwn() {
    newest_ = std::min(newest_, shortest_);
    own_ = std::min(newest_, before_);
    remembered_ += since_;
    if (remembered_ < kRemembered) return;
    remembered_ = 0;
    before_ = std::exchange(newest_, kUnbound);
  }

  double rate_ = kUnbound;
  double since_ = 0, sent_ = 0, shortest_ = kUnbound;  // of this period
  double own_ = 0, newest_ = kUnbound, before_ = kUnbound, remembered_ = 0;
};

}  // namespace palpate
