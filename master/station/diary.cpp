#include "master/station/diary.h"

#include <algorithm>
#include <utility>

#include "master/haptics/record/event_words.h"
#include "master/haptics/record/tick_words.h"

namespace palpate {
namespace {

constexpr double kRepeat = 0.5;  // what is said again so soon is not news [s]

bool IsTrouble(OperatorState state) {
  return state == OperatorState::kEstop || state == OperatorState::kHold ||
         state == OperatorState::kDisconnected;
}

}  // namespace

void Diary::Say(double t, bool is_trouble, std::string text) {
  const std::scoped_lock lock(mutex_);
  const bool is_known = std::ranges::any_of(sayings_, [&](const Saying& saying) {
    return saying.text == text && t - saying.t < kRepeat;
  });
  if (is_known) return;
  sayings_.push_back({++number_, t, is_trouble, std::move(text)});
  if (sayings_.size() > kKept) sayings_.pop_front();
  is_news_ = true;
}

void Diary::See(double t, const TickRecord& tick) {
  if (!last_ || last_->state != tick.state) {
    Say(t, IsTrouble(tick.state), "now " + std::string(ToString(tick.state)));
  }
  if (last_) {
    for (std::string& act : ActsInWords(*last_, tick)) Say(t, false, std::move(act));
  }
  last_ = tick;
}

void Diary::See(double t, Events events) {
  using Weight = EventWords::Weight;
  for (const EventWords& told : InWords(events)) {
    if (told.weight == Weight::kUsual) continue;
    Say(t, told.weight == Weight::kTrouble, std::string(told.words));
  }
}

std::optional<std::vector<Saying>> Diary::TakeNews() {
  const std::scoped_lock lock(mutex_);
  if (!std::exchange(is_news_, false)) return std::nullopt;
  return std::vector<Saying>(sayings_.begin(), sayings_.end());
}

}  // namespace palpate
