// The lease of the only operator. It lasts as long as the stream. A holder that sent no valid newer
// command for `kSilence` loses it to the next client that requests it, because a silently cut link
// may not end by itself for minutes; one that is not engaged, after `kIdleSilence`.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "palpate/v1/state.pb.h"

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"
#include "slave/live/slave.h"

namespace palpate {

// Thread-safe. Independent of gRPC.
class OperatorLease {
 public:
  static constexpr std::chrono::seconds kSilence{5}, kIdleSilence{1};
  static constexpr std::size_t kMaxNameLength = 64;  // [characters]

  using Ticket = std::uint64_t;
  struct Refusal {
    std::string why;  // for the client
  };
  using Answer = std::variant<Ticket, Refusal>;
  // Called once with a reason if the lease is given to another client.
  using Dismiss = std::function<void(const std::string& reason)>;

  // Called, with the lease's mutex held, for each newer state that the holder acknowledges:
  // round-trip time of `peer` [s].
  using OnRoundTrip = std::function<void(const std::string& peer, double seconds)>;

  // Runs a task that may wait for the disk. Called with the lease's mutex held.
  using RunApart = std::function<void(std::function<void()> task)>;

  // `slave` outlives the lease.
  OperatorLease(Slave& slave, Clock::duration silence, RunApart run_apart,
                OnRoundTrip on_round_trip)
      : slave_(slave),
        silence_(silence),
        run_apart_(std::move(run_apart)),
        on_round_trip_(std::move(on_round_trip)) {}

  // Gives the lease to `peer`, or returns the reason of the rejection. `name`: from the
  // certificate, or in plain text from the metadata of the call; nullopt: not known yet. Throws
  // RejectedCall: there is no manipulator.
  Answer RequestTicket(const std::string& peer, const std::optional<std::string>& name,
                       Dismiss dismiss);
  // Passes on a command. Returns false for a malformed command, which is counted and not executed
  // (commands that the slave rejects are flagged by the slave). No effect without the lease. An
  // emergency stop is executed regardless of the rest of the command.
  bool Command(Ticket ticket, const v1::OperatorCommand& message);
  // Ends operating. Idempotent.
  void Release(Ticket ticket);
  // Ends the holder's stream because of `reason`. Throws RejectedCall: there is no operator.
  void Evict(const std::string& reason);

  // Throws RejectedCall: another connection than that of `peer` holds the lease. A connection
  // has one certificate, so this identifies the operator.
  void RefuseOthers(const std::string& peer) const;
  // Throws RejectedCall like RefuseOthers, and also if there is no operator. `what`: the action
  // that only a connected operator may perform.
  void RequireHeldBy(const std::string& peer, const std::string& what) const;
  // Throws RejectedCall if a client holds the lease, or it is closed.
  void RequireFree() const;
  // Calls RequireFree and closes the lease, because the slave changes to another scene.
  void Close();
  void Reopen();
  [[nodiscard]] bool is_closed() const { return is_closed_; }
  // Returns whether a call of `peer`, or of a client named `name`, is that of the operator.
  [[nodiscard]] bool IsHeldBy(const std::string& peer,
                              const std::optional<std::string>& name) const;
  [[nodiscard]] std::string holder_name() const;  // empty: none, or not yet named
  [[nodiscard]] std::uint64_t malformed() const;  // commands, since the start

 private:
  struct Holder {
    Ticket ticket = 0;                    // 0: no operator
    std::optional<std::string> known_as;  // name at the time of the lease; nullopt: not known yet
    std::string name, peer;
    bool engaged = false;        // according to the newest command
    Time received_at{};          // a valid command newer than all before
    std::uint64_t sequence = 0;  // of that command
    Dismiss dismiss;
    std::uint64_t state_sequence = 0;  // the newest acknowledged state
  };

  // These functions require mutex_ to be held.
  void RequireManipulator() const;
  void RequireUnused() const;
  [[nodiscard]] std::string DescribeHolder() const;
  [[nodiscard]] std::string NameOfHolder() const { return holder_.known_as.value_or(holder_.name); }
  void ReportRoundTrip(const OperatorCommand& command);
  void StopTool();

  Slave& slave_;
  const Clock::duration silence_;
  const RunApart run_apart_;
  const OnRoundTrip on_round_trip_;
  mutable PriorityInheritanceMutex
      mutex_;  // guards everything below and the order of calls to slave_, emergency stops excepted
  Holder holder_;
  std::atomic<bool> will_record_stop_ = false;  // a task that records a stop waits
  std::atomic<bool> is_closed_ = false;
  Ticket last_ticket_ = 0;
  std::uint64_t malformed_ = 0;
};

}  // namespace palpate
