// Datagrams beside a stream, for states and commands, of which only the newest counts. The stream
// hands over the keys and stays in control. Datagrams without these keys are ignored and never
// answered.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <thread>

#include <sys/socket.h>

#include "shared/link/clock_offset.h"
#include "shared/link/datagram_seal.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"
#include "shared/state/datagram_count.h"

namespace palpate {

// Share of datagrams that are sent: all, unless they compete with the stream.
//
// Datagrams help on links with random loss. A link with too little bandwidth first queues packets
// and then drops them, and the stream slows down more than the datagrams. Therefore the share is
// halved while round trips show queueing, the stream is stalled, or the loss is above random loss.
// Otherwise it rises linearly. The least share keeps measuring the link.
class DatagramPace {
 public:
  static constexpr double kFirst = 0.25;      // initial share, doubled until the first halving [-]
  static constexpr double kLeast = 0.05;      // share [-]
  static constexpr double kPeriod = 1;        // between decisions, at least a round trip [s]
  static constexpr double kLost = 0.12;       // share [-]
  static constexpr double kStanding = 20e-3;  // queueing delay of the shortest round trip [s]
  static constexpr double kShaken = 0.5;      // accepted variation, relative to the base round trip
  static constexpr double kStreamStalled = 1;  // plus three round trips: the stream is stalled [s]
  static constexpr double kUnheard = 2;        // plus a round trip: the peer is absent [s]

  // Whether one more datagram may be sent.
  bool Allows(Time now) noexcept {
    const bool is_heard = SecondsBetween(heard_at_, now) < kUnheard + own_.OrZero();
    credit_ = std::min(1.0, credit_ + (is_heard ? share_ : kLeast));
    if (credit_ < 1) return false;
    credit_ -= 1;
    return true;
  }
  // Adds feedback of the peer: count of received datagrams, and a round trip [s].
  void Hear(const DatagramCount& seen, double round_trip, Time now) noexcept {
    heard_at_ = now;
    if (round_trip > 0) shortest_ = std::min(shortest_, round_trip);  // nor NaN
    if (begun_at_ == Time{}) return Begin(seen, now);
    const double period = SecondsBetween(begun_at_, now);
    if (period < std::max(kPeriod, own_.OrZero())) return;
    own_.Learn(shortest_, period);
    // A peer that does not count gives no information about loss.
    const double went = static_cast<double>(seen.newest) - static_cast<double>(before_.newest);
    const double arrived =
        static_cast<double>(seen.received) - static_cast<double>(before_.received);
    const bool is_stalled = stream_moved_at_ != Time{} && SecondsBetween(stream_moved_at_, now) >
                                                              kStreamStalled + 3 * own_.OrZero();
    const bool waits = own_.Waits(shortest_, kStanding, kShaken);
    const bool crowds = waits || is_stalled || arrived < (1 - kLost) * went - kFew;
    crowded_ = crowded_ || crowds;
    const double more = crowded_ ? share_ + kMore : 2 * share_;
    share_ = crowds ? std::max(kLeast, share_ / 2) : std::min(1.0, more);
    Begin(seen, now);
  }
  // The stream has written one more message.
  void StreamMoves(Time now) noexcept { stream_moved_at_ = now; }
  [[nodiscard]] double share() const noexcept { return share_; }

 private:
  static constexpr double kMore = 0.1;  // share of a period
  static constexpr double kFew = 3;     // accepted loss of single datagrams

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

class DatagramLine {
 public:
  struct Keys {
    DatagramKey send, receive;
  };
  // Feedback of the peer: count of received datagrams, and the round trip [s].
  struct LinkFeedback {
    DatagramCount seen = {};
    double round_trip = 0;
  };
  // Called on this object's thread with a decrypted message, valid until it returns.
  using Take = std::function<LinkFeedback(std::string_view plain)>;
  enum class Role : std::uint8_t {
    kCalls,    // sends to a known address
    kAnswers,  // answers the source of the newest authentic datagram
  };

  // A path without datagrams for this time counts as dead.
  static constexpr std::chrono::seconds kSilence{1};

  // `at`: the peer's address for kCalls, the own address for kAnswers. If that port is in use,
  // another one is taken. Throws std::system_error without a socket or with an invalid address.
  DatagramLine(Role role, const sockaddr_storage& at, const Keys& keys, Take take);
  // No callback is called afterwards.
  ~DatagramLine();
  DatagramLine(const DatagramLine&) = delete;
  DatagramLine& operator=(const DatagramLine&) = delete;

  // Sends without waiting or guarantee. Messages that are too large, have no known peer, or exceed
  // the pace (see DatagramPace) are dropped. Call it from one thread at a time.
  void Send(std::string_view plain) noexcept;
  // The stream has written one more message. Thread-safe.
  void StreamMoves() noexcept;
  // Count of received datagrams, for the peer. Thread-safe.
  [[nodiscard]] DatagramCount seen() const { return {newest_, received_}; }
  // Port of this end.
  [[nodiscard]] std::uint16_t port() const;

 private:
  // A file descriptor, closed by the destructor.
  struct Descriptor {
    explicit Descriptor(int opened);  // throws std::system_error if invalid
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    const int fd;
  };

  void Run(const std::stop_token& stop);
  void TakeNext();
  // Limits the number of processed datagrams per time, against floods.
  void Pace();

  const Role role_;
  const Descriptor socket_, wake_;
  const Take take_;
  DatagramSealer sealer_;
  DatagramOpener opener_;  // used by the thread only, like the next two
  Time window_{};
  int looked_at_ = 0;
  std::atomic<std::uint64_t> newest_{0}, received_{0};
  PriorityInheritanceMutex mutex_;        // guards the next three
  std::optional<sockaddr_storage> peer_;  // nullopt: unknown yet; always set for kCalls
  Time heard_at_{};
  DatagramPace pace_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
