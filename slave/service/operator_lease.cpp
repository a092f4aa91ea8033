#include "slave/service/operator_lease.h"

#include <utility>

#include "shared/wire/state_message.h"

namespace palpate {
namespace {

// At most `kLongestName` characters of UTF-8, without control characters: it goes into messages.
std::string Presentable(const std::string& name) {
  std::string shown;
  std::size_t characters = 0;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool starts_character = (byte & 0xC0U) != 0x80U;
    if (starts_character && ++characters > OperatorLease::kLongestName) break;
    shown += byte < 0x20 || byte == 0x7F ? ' ' : c;
  }
  return shown;
}

}  // namespace

std::variant<OperatorLease::Ticket, OperatorLease::HeldBy> OperatorLease::Ask(
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
    holder_ = {ticket, "", peer, now, std::move(dismiss)};
  }
  if (dismiss_silent_holder) {
    dismiss_silent_holder("no command for too long: the lease went to " + peer);
  }
  return ticket;
}

bool OperatorLease::Command(Ticket ticket, const v1::OperatorCommand& message) {
  const std::scoped_lock lock(mutex_);
  if (ticket != holder_.ticket) return true;
  holder_.heard_at = Clock::now();
  if (holder_.name.empty()) holder_.name = Presentable(message.operator_name());
  std::string reason;
  const auto command = FromProto(message, &reason);
  if (!command) {
    ++malformed_;
    return false;
  }
  slave_.Command(*command);
  return true;
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
  const std::string name = holder_.name.empty() ? "an operator without a name" : holder_.name;
  return name + " (" + holder_.peer + ")";
}

}  // namespace palpate
