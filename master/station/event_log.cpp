#include "master/station/event_log.h"

#include <algorithm>
#include <utility>

#include "master/session/tick_text.h"

namespace palpate {
namespace {

constexpr double kRepeat = 0.5;  // repetitions within this time are not logged [s]

bool IsTrouble(OperatorState state) {
  return state == OperatorState::kEstop || state == OperatorState::kStopRequested ||
         state == OperatorState::kHold || state == OperatorState::kDisconnected;
}

}  // namespace

void EventLog::Append(double t, bool is_trouble, std::string text) {
  const std::scoped_lock lock(mutex_);
  const bool is_known = std::ranges::any_of(
      entries_, [&](const LogEntry& entry) { return entry.text == text && t - entry.t < kRepeat; });
  if (is_known) return;
  entries_.push_back({++number_, t, is_trouble, std::move(text)});
  if (entries_.size() > kMaxKept) entries_.pop_front();
  is_news_ = true;
}

void EventLog::AppendChanges(double t, const TickRecord& tick) {
  if (!last_ || last_->state != tick.state) {
    Append(t, IsTrouble(tick.state), "now " + std::string(ToString(tick.state)));
  }
  if (last_) {
    for (std::string& act : ActsInWords(*last_, tick)) Append(t, false, std::move(act));
  }
  last_ = tick;
}

void EventLog::AppendEvents(double t, Events events) {
  using Weight = EventWords::Weight;
  for (const EventWords& event : InWords(events)) {
    if (event.weight == Weight::kUsual) continue;
    Append(t, event.weight == Weight::kTrouble, std::string(event.words));
  }
}

std::optional<std::vector<LogEntry>> EventLog::TakeNew() {
  const std::scoped_lock lock(mutex_);
  if (!std::exchange(is_news_, false)) return std::nullopt;
  return std::vector<LogEntry>(entries_.begin(), entries_.end());
}

}  // namespace palpate
