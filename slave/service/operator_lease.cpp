#include "slave/service/operator_lease.h"

#include <stdexcept>
#include <utility>

#include "shared/text/text.h"
#include "shared/wire/state_message.h"

namespace palpate {

std::variant<OperatorLease::Ticket, OperatorLease::HeldBy> OperatorLease::RequestTicket(
    const std::string& peer, Dismiss dismiss) {
  Dismiss dismiss_silent_holder;
  Ticket ticket = 0;
  {
    const std::scoped_lock lock(mutex_);
    const Time now = Clock::now();
    if (holder_.ticket != 0) {
      if (now - holder_.heard_at < silence_) return HeldBy{DescribeHolder()};
      dismiss_silent_holder = std::move(holder_.dismiss);
      holder_ = {};
      slave_.EndOperating();
    }
    slave_.BeginOperating();
    ticket = ++last_ticket_;
    holder_ = {ticket, "", peer, now, 0, std::move(dismiss)};
  }
  if (dismiss_silent_holder) {
    dismiss_silent_holder("no command for too long: the lease was passed to " + peer);
  }
  return ticket;
}

bool OperatorLease::Command(Ticket ticket, const v1::OperatorCommand& message) {
  const std::scoped_lock lock(mutex_);
  if (ticket != holder_.ticket) return true;
  if (message.stop()) {
    slave_.EmergencyStop("by the operator, " + DescribeHolder());
  }
  if (holder_.name.empty()) holder_.name = Presentable(message.operator_name(), kLongestName);
  std::string reason;
  const auto command = FromProto(message, &reason);
  if (!command) {
    ++malformed_;
    return false;
  }
  const bool is_newer = command->sequence > holder_.sequence;
  if (slave_.Command(*command) && is_newer) {
    holder_.heard_at = Clock::now();
    holder_.sequence = command->sequence;
    ReportRoundTrip(*command);
  }
  return true;
}

void OperatorLease::ReportRoundTrip(const OperatorCommand& command) {
  if (!command.echo || command.state_sequence <= holder_.state_sequence) return;
  holder_.state_sequence = command.state_sequence;
  if (on_round_trip_) on_round_trip_(holder_.peer, SecondsBetween(*command.echo, holder_.heard_at));
}

void OperatorLease::RefuseOthers(const std::string& peer) const {
  const std::scoped_lock lock(mutex_);
  if (holder_.ticket == 0 || holder_.peer == peer) return;
  throw std::logic_error("only the operator may change settings: " + DescribeHolder());
}

void OperatorLease::RequireHeldBy(const std::string& peer, const std::string& what) const {
  RefuseOthers(peer);
  const std::scoped_lock lock(mutex_);
  if (holder_.ticket != 0 && holder_.peer == peer) return;
  throw std::logic_error(what + " only by the current operator, or by an admin");
}

void OperatorLease::Release(Ticket ticket) {
  const std::scoped_lock lock(mutex_);
  if (ticket == 0 || ticket != holder_.ticket) return;
  holder_ = {};
  slave_.EndOperating();
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
  const std::string name = holder_.name.empty() ? "an unnamed operator" : holder_.name;
  return name + " (" + holder_.peer + ")";
}

}  // namespace palpate
