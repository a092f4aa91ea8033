// How many of the datagrams that could go do go: all, until they crowd out the stream beside them.
#pragma once

#include <algorithm>

#include "shared/link/base_round_trip.h"
#include "shared/state/clock.h"
#include "shared/state/datagram_count.h"

namespace palpate {

// A line that loses packets at random is what datagrams are for; one that is too thin for them and
// the stream loses them too, but first makes them wait, and the stream more than them, which backs
// off from both. So the share that goes is halved while round trips wait, the stream stands, or
// more is lost than chance would, and rises evenly otherwise. What goes at least shows whether it
// may.
class DatagramPace {
 public:
  static constexpr double kFirst = 0.25;      // share, doubled until they crowd [-]
  static constexpr double kLeast = 0.05;      // share [-]
  static constexpr double kPeriod = 1;        // of a decision, or a round trip [s]
  static constexpr double kLost = 0.12;       // share [-]
  static constexpr double kStanding = 20e-3;  // that the shortest trip of a period waited [s]
  static constexpr double kShaken = 0.5;      // of a line's own round trip, by itself
  static constexpr double kStreamStands = 1;  // and three round trips [s]
  static constexpr double kUnheard = 2;       // and a round trip: nobody is there [s]

  // Whether one more may go.
  bool Allows(Time now) noexcept {
    const bool is_heard = SecondsBetween(heard_at_, now) < kUnheard + own_.OrZero();
    credit_ = std::min(1.0, credit_ + (is_heard ? share_ : kLeast));
    if (credit_ < 1) return false;
    credit_ -= 1;
    return true;
  }
  // What the peer tells of ours; a message and its answer took so long [s].
  void Hear(const DatagramCount& seen, double round_trip, Time now) noexcept {
    heard_at_ = now;
    if (round_trip > 0) shortest_ = std::min(shortest_, round_trip);  // nor NaN
    if (begun_at_ == Time{}) return Begin(seen, now);
    const double period = SecondsBetween(begun_at_, now);
    if (period < std::max(kPeriod, own_.OrZero())) return;
    own_.Learn(shortest_, period);
    // Who does not count tells nothing of what is lost.
    const double went = static_cast<double>(seen.newest) - static_cast<double>(before_.newest);
    const double arrived =
        static_cast<double>(seen.received) - static_cast<double>(before_.received);
    const bool stands = stream_moved_at_ != Time{} &&
                        SecondsBetween(stream_moved_at_, now) > kStreamStands + 3 * own_.OrZero();
    const bool waits = own_.Waits(shortest_, kStanding, kShaken);
    const bool crowds = waits || stands || arrived < (1 - kLost) * went - kFew;
    crowded_ = crowded_ || crowds;
    const double more = crowded_ ? share_ + kMore : 2 * share_;
    share_ = crowds ? std::max(kLeast, share_ / 2) : std::min(1.0, more);
    Begin(seen, now);
  }
  // The stream took one more.
  void StreamMoves(Time now) noexcept { stream_moved_at_ = now; }
  [[nodiscard]] double share() const noexcept { return share_; }

 private:
  static constexpr double kMore = 0.1;  // share of a period
  static constexpr double kFew = 3;     // lost by chance, where few went

  void Begin(const DatagramCount& seen, Time now) noexcept {
    begun_at_ = now;
    before_ = seen;
    shortest_ = BaseRoundTrip::kUnknown;
  }

  double share_ = kFirst, credit_ = 1;
  bool crowded_ = false;  // ever
  DatagramCount before_;
  Time heard_at_{}, begun_at_{}, stream_moved_at_{};
  double shortest_ = BaseRoundTrip::kUnknown;  // of this period [s]
  BaseRoundTrip own_;
};

}  // namespace palpate
