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

// DatagramPace limits the share of datagrams that are sent. All are sent unless they compete with
// the stream.
//
// Datagrams help on links with random loss. A link with too little bandwidth first queues packets
// and then drops them, and the stream slows down more than the datagrams. Therefore the share is
// halved while round trips show queueing, the stream is stalled, or the loss is above random loss.
// Otherwise it rises linearly. The least share keeps measuring the link.
class DatagramPace {
 public:
  // The share starts at kInitialShare and doubles until the first halving [-].
  static constexpr double kInitialShare = 0.25;
  static constexpr double kMinShare = 0.05;  // least share [-]
  // Time between decisions, at least a round trip [s].
  static constexpr double kPeriod = 1;
  static constexpr double kMaxLoss = 0.12;  // accepted random loss [-]
  // Accepted queueing delay of the shortest round trip [s].
  static constexpr double kMaxQueueing = 20e-3;
  // Accepted variation of the round trip, relative to the base round trip [-].
  static constexpr double kMaxVariation = 0.5;
  // The stream is stalled if it writes nothing for this time plus three round trips [s].
  static constexpr double kStreamStalled = 1;
  // The peer is absent if it sends nothing for this time plus a round trip [s].
  static constexpr double kAbsence = 2;

  // Returns whether one more datagram may be sent.
  bool Allows(Time now) noexcept {
    const bool is_present =
        SecondsBetween(received_at_, now) < kAbsence + base_round_trip_.OrZero();
    credit_ = std::min(1.0, credit_ + (is_present ? share_ : kMinShare));
    if (credit_ < 1) return false;
    credit_ -= 1;
    return true;
  }
  // Adds feedback of the peer: count of received datagrams, and a round trip [s].
  void AddFeedback(const DatagramCount& seen, double round_trip, Time now) noexcept {
    received_at_ = now;
    if (round_trip > 0) min_round_trip_ = std::min(min_round_trip_, round_trip);  // skips NaN, too
    if (period_began_ == Time{}) return BeginPeriod(seen, now);
    const double period = SecondsBetween(period_began_, now);
    if (period < std::max(kPeriod, base_round_trip_.OrZero())) return;
    base_round_trip_.Learn(min_round_trip_, period);
    // A peer that does not count gives no information about loss.
    const double sent = static_cast<double>(seen.newest) - static_cast<double>(before_.newest);
    const double arrived =
        static_cast<double>(seen.received) - static_cast<double>(before_.received);
    const bool is_stalled =
        stream_moved_at_ != Time{} &&
        SecondsBetween(stream_moved_at_, now) > kStreamStalled + 3 * base_round_trip_.OrZero();
    const bool waits = base_round_trip_.Waits(min_round_trip_, kMaxQueueing, kMaxVariation);
    const bool crowds = waits || is_stalled || arrived < (1 - kMaxLoss) * sent - kAcceptedLosses;
    crowded_ = crowded_ || crowds;
    const double more = crowded_ ? share_ + kIncrease : 2 * share_;
    share_ = crowds ? std::max(kMinShare, share_ / 2) : std::min(1.0, more);
    BeginPeriod(seen, now);
  }
  // Records that the stream has written one more message.
  void StreamMoves(Time now) noexcept { stream_moved_at_ = now; }
  [[nodiscard]] double share() const noexcept { return share_; }

 private:
  static constexpr double kIncrease = 0.1;      // increase of the share per period [-]
  static constexpr double kAcceptedLosses = 3;  // datagrams that may be lost in a period

  void BeginPeriod(const DatagramCount& seen, Time now) noexcept {
    period_began_ = now;
    before_ = seen;
    min_round_trip_ = BaseRoundTrip::kUnknown;
  }

  double share_ = kInitialShare, credit_ = 1;
  bool crowded_ = false;  // the share was halved at least once
  DatagramCount before_;
  Time received_at_{}, period_began_{}, stream_moved_at_{};
  double min_round_trip_ = BaseRoundTrip::kUnknown;  // shortest round trip of this period [s]
  BaseRoundTrip base_round_trip_;
};

class DatagramLine {
 public:
  struct Keys {
    DatagramKey send, receive;
  };
  // LinkFeedback is the peer's count of received datagrams, and the round trip [s].
  struct LinkFeedback {
    DatagramCount seen = {};
    double round_trip = 0;
  };
  // OnMessage is called on this object's thread with a decrypted message, which is valid until the
  // call returns.
  using OnMessage = std::function<LinkFeedback(std::string_view plain)>;
  enum class Role : std::uint8_t {
    kCalls,    // sends to a known address
    kAnswers,  // answers the source of the newest authentic datagram
  };

  // A path is dead if no datagram arrives for this time.
  static constexpr std::chrono::seconds kSilence{1};

  // `at` is the peer's address for kCalls, and the own address for kAnswers. If that port is in
  // use, another one is taken. Throws std::system_error without a socket or with an invalid
  // address.
  DatagramLine(Role role, const sockaddr_storage& at, const Keys& keys, OnMessage on_message);
  // The destructor ends the thread; no callback is called afterwards.
  ~DatagramLine();
  DatagramLine(const DatagramLine&) = delete;
  DatagramLine& operator=(const DatagramLine&) = delete;

  // Sends without waiting or guarantee. Messages that are too large, have no known peer, or exceed
  // the pace (see DatagramPace) are dropped. Call it from one thread at a time.
  void Send(std::string_view plain) noexcept;
  // Records that the stream has written one more message. Thread-safe.
  void StreamMoves() noexcept;
  // Returns the count of received datagrams, for the peer. Thread-safe.
  [[nodiscard]] DatagramCount seen() const { return {newest_, received_}; }
  // Returns the port of this end.
  [[nodiscard]] std::uint16_t port() const;

 private:
  // Descriptor owns a file descriptor and closes it in its destructor.
  struct Descriptor {
    explicit Descriptor(int opened);  // throws std::system_error if invalid
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    const int fd;
  };

  void Run(const std::stop_token& stop);
  void ReceiveNext();
  // Limits the number of processed datagrams per time, against floods.
  void Pace();

  const Role role_;
  const Descriptor socket_, wake_;
  const OnMessage on_message_;
  DatagramSealer sealer_;
  DatagramOpener opener_;  // used by the thread only, like the next two
  Time window_began_{};
  int processed_ = 0;
  std::atomic<std::uint64_t> newest_{0}, received_{0};
  PriorityInheritanceMutex mutex_;        // guards the next three
  std::optional<sockaddr_storage> peer_;  // nullopt: unknown yet; always set for kCalls
  Time received_at_{};
  DatagramPace pace_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
