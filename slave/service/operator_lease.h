// One operator at a time. The lease lasts as long as the stream; a holder from whom no valid, newer
// command came for `kSilence` gives way to the next who asks, since a line that was cut silently
// may not end by itself for minutes.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <variant>

#include "palpate/v1/state.pb.h"

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Thread-safe. Knows nothing of gRPC.
class OperatorLease {
 public:
  static constexpr std::chrono::seconds kSilence{5};
  static constexpr std::size_t kLongestName = 64;  // [characters]

  using Ticket = std::uint64_t;
  struct HeldBy {
    std::string who;  // name and peer, for the one who is refused
  };
  // Called once with a reason if the lease is given to somebody else.
  using Dismiss = std::function<void(const std::string& reason)>;

  // Called, with the lease's mutex held, for each newer state that the holder tells of: how long it
  // went to `peer` and came back [s].
  using OnRoundTrip = std::function<void(const std::string& peer, double seconds)>;

  // `slave` outlives the lease.
  explicit OperatorLease(Slave& slave, Clock::duration silence = kSilence,
                         OnRoundTrip on_round_trip = {})
      : slave_(slave), silence_(silence), on_round_trip_(std::move(on_round_trip)) {}

  // Begins operating for `peer`, or tells who does.
  std::variant<Ticket, HeldBy> RequestTicket(const std::string& peer, Dismiss dismiss);
  // Hands on a command. False: malformed, counted, not followed (what the slave itself refuses, it
  // flags itself). Nothing happens without the lease. An emergency stop counts whatever else the
  // command says.
  bool Command(Ticket ticket, const v1::OperatorCommand& message);
  // Ends operating. Idempotent.
  void Release(Ticket ticket);

  // Throws std::logic_error: somebody operates from another connection than `peer`'s. A connection
  // has one certificate, so that this is the operator's own.
  void RefuseOthers(const std::string& peer) const;
  // The same where nobody operates, for what an operator may do only while operating: `what`.
  void RequireHeldBy(const std::string& peer, const std::string& what) const;
  [[nodiscard]] std::string holder_name() const;  // empty: nobody, or not said yet
  [[nodiscard]] std::uint64_t malformed() const;  // commands, since the start

 private:
  struct Holder {
    Ticket ticket = 0;  // 0: nobody
    std::string name, peer;
    Time heard_at{};             // a valid command newer than all before
    std::uint64_t sequence = 0;  // of that command
    Dismiss dismiss;
    std::uint64_t state_sequence = 0;  // the newest told of
  };

  // With mutex_ held, both.
  [[nodiscard]] std::string DescribeHolder() const;
  void ReportRoundTrip(const OperatorCommand& command);

  Slave& slave_;
  const Clock::duration silence_;
  const OnRoundTrip on_round_trip_;
  mutable PriorityInheritanceMutex
      mutex_;  // guards everything below and the order of calls to slave_
  Holder holder_;
  Ticket last_ticket_ = 0;
  std::uint64_t malformed_ = 0;
};

}  // namespace palpate
