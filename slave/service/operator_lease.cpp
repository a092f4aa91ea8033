#include "slave/service/operator_lease.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"
#include "shared/wire/state_message.h"
#include "slave/service/status.h"

namespace palpate {
OperatorLease::Answer OperatorLease::RequestTicket(const std::string& peer,
                                                   const std::optional<std::string>& name,
                                                   Dismiss dismiss) {
  Dismiss dismiss_silent_holder;
  Ticket ticket = 0;
  {
    const std::scoped_lock lock(mutex_);
    const Time now = Clock::now();
    if (is_closed_) throw RejectedCall(v1::ERROR_REASON_NEW_SCENE, kNewScene);
    RequireManipulator();
    if (holder_.ticket != 0) {
      const auto silence =
          holder_.engaged ? silence_ : std::min<Clock::duration>(silence_, kIdleSilence);
      if (now - holder_.received_at < silence) {
        return Refusal{"the lease is held by " + DescribeHolder() +
                       ": it becomes free when that stream ends"};
      }
    }
    if (holder_.ticket != 0) {
      dismiss_silent_holder = std::move(holder_.dismiss);
      slave_.EndOperating();
    }
    slave_.BeginOperating();
    ticket = ++last_ticket_;
    holder_ = {.ticket = ticket, .known_as = name, .peer = peer, .received_at = now};
    holder_.dismiss = std::move(dismiss);
  }
  if (dismiss_silent_holder) {
    dismiss_silent_holder("no command for too long: the lease was passed to " + peer);
  }
  return ticket;
}

void OperatorLease::RequireManipulator() const {
  const Scene scene = slave_.Describe().scene;
  if (scene.manipulator.source != ManipulatorOptions::Source::kNone) return;
  throw RejectedCall(v1::ERROR_REASON_NO_MANIPULATOR,
                     scene.name.empty()
                         ? "nobody can operate: the slave has no scene yet"
                         : "nobody can operate: the scene has no manipulator (manipulator: none)");
}

bool OperatorLease::Command(Ticket ticket, const v1::OperatorCommand& message) {
  const std::scoped_lock lock(mutex_);
  if (ticket != holder_.ticket) return true;
  if (message.stop()) StopTool();
  if (holder_.name.empty()) holder_.name = Presentable(message.operator_name(), kMaxNameLength);
  std::string reason;
  const auto command = FromProto(message, &reason);
  if (!command) {
    ++malformed_;
    return false;
  }
  const bool is_newer = command->sequence > holder_.sequence;
  if (slave_.Command(*command) && is_newer) {
    holder_.received_at = Clock::now();
    holder_.engaged = command->engaged;
    holder_.sequence = command->sequence;
    ReportRoundTrip(*command);
  }
  return true;
}

// Each stop command stops the tool. Only one record of a stop waits to be written at a time.
void OperatorLease::StopTool() {
  slave_.StopTool();
  if (will_record_stop_.exchange(true)) return;
  run_apart_([this, reason = "by the operator, " + DescribeHolder()] {
    will_record_stop_ = false;
    slave_.RecordStop(reason);
  });
}

void OperatorLease::ReportRoundTrip(const OperatorCommand& command) {
  if (!command.echo || command.state_sequence <= holder_.state_sequence) return;
  holder_.state_sequence = command.state_sequence;
  if (on_round_trip_)
    on_round_trip_(holder_.peer, SecondsBetween(*command.echo, holder_.received_at));
}

void OperatorLease::RefuseOthers(const std::string& peer) const {
  const std::scoped_lock lock(mutex_);
  if (holder_.ticket == 0 || holder_.peer == peer) return;
  throw RejectedCall(v1::ERROR_REASON_LEASE_HELD,
                     "only the operator may change settings: " + DescribeHolder());
}

void OperatorLease::RequireUnused() const {
  if (is_closed_) throw RejectedCall(v1::ERROR_REASON_NEW_SCENE, kNewScene);
  if (holder_.ticket == 0) return;
  throw RejectedCall(
      v1::ERROR_REASON_LEASE_HELD,
      "a scene can be set up only while nobody operates: the lease is held by " + DescribeHolder());
}

void OperatorLease::RequireFree() const {
  const std::scoped_lock lock(mutex_);
  RequireUnused();
}

void OperatorLease::Close() {
  const std::scoped_lock lock(mutex_);
  RequireUnused();
  is_closed_ = true;
}

void OperatorLease::Reopen() {
  const std::scoped_lock lock(mutex_);
  is_closed_ = false;
}

void OperatorLease::RequireHeldBy(const std::string& peer, const std::string& what) const {
  RefuseOthers(peer);
  const std::scoped_lock lock(mutex_);
  if (holder_.ticket != 0 && holder_.peer == peer) return;
  throw RejectedCall(v1::ERROR_REASON_LEASE_HELD,
                     what + " only by the current operator, or by an admin");
}

void OperatorLease::Release(Ticket ticket) {
  const std::scoped_lock lock(mutex_);
  if (ticket == 0 || ticket != holder_.ticket) return;
  holder_ = {};
  slave_.EndOperating();
}

void OperatorLease::Evict(const std::string& reason) {
  Dismiss dismiss;
  {
    const std::scoped_lock lock(mutex_);
    if (holder_.ticket == 0) {
      throw RejectedCall(v1::ERROR_REASON_NO_OPERATOR, "there is no operator");
    }
    dismiss = std::move(holder_.dismiss);
    holder_ = {};
    slave_.EndOperating();
  }
  dismiss("evicted by an administrator: " + reason);
}

bool OperatorLease::IsHeldBy(const std::string& peer,
                             const std::optional<std::string>& name) const {
  const std::scoped_lock lock(mutex_);
  return holder_.ticket != 0 &&
         (holder_.peer == peer || (name && !name->empty() && *name == NameOfHolder()));
}

std::string OperatorLease::holder_name() const {
  const std::scoped_lock lock(mutex_);
  return holder_.name;
}

std::uint64_t OperatorLease::malformed() const {
  const std::scoped_lock lock(mutex_);
  return malformed_;
}

std::string OperatorLease::DescribeHolder() const {
  return (holder_.name.empty() ? "an unnamed operator" : holder_.name) + " (" + holder_.peer + ")";
}

}  // namespace palpate
