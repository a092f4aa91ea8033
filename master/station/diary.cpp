#include "master/station/diary.h"

#include <algorithm>
#include <array>
#include <utility>

#include "master/haptics/record/tick_words.h"

namespace palpate {
namespace {

struct EventWords {
  Event event;
  bool is_trouble;
  const char* words;
};
constexpr std::array kEventWords{
    EventWords{Event::kPuncture, true, "the tool broke through the surface"},
    EventWords{Event::kTrackingLost, true, "the eyes lost the tool"},
    EventWords{Event::kTrackingRegained, false, "the eyes found the tool again"},
    EventWords{Event::kLimit, true,
               "the tool is held at its limit: workspace, speed, force or depth"},
    EventWords{Event::kHold, true, "the tool holds its place"},
    EventWords{Event::kEstop, true, "emergency stop at the slave"},
    EventWords{Event::kModelChanged, false, "the slave's model was replaced"},
    EventWords{Event::kCommandRefused, true, "the slave refused a command"}};

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
  for (const EventWords& known : kEventWords) {
    if (events.Has(known.event)) Say(t, known.is_trouble, known.words);
  }
}

std::optional<std::vector<Saying>> Diary::TakeNews() {
  const std::scoped_lock lock(mutex_);
  if (!std::exchange(is_news_, false)) return std::nullopt;
  return std::vector<Saying>(sayings_.begin(), sayings_.end());
}

}  // namespace palpate
