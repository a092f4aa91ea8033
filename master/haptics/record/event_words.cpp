#include "master/haptics/record/event_words.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace palpate {
namespace {

using enum EventWords::Weight;

constexpr std::array kEventWords{
    EventWords{Event::kContact, kUsual, "contact: the tool touches the object"},
    EventWords{Event::kRelease, kUsual, "the contact ended"},
    EventWords{Event::kPuncture, kTrouble, "the tool broke through the surface"},
    EventWords{Event::kTrackingLost, kTrouble, "tracking of the tool is lost"},
    EventWords{Event::kTrackingRegained, kNews, "tracking of the tool is regained"},
    EventWords{Event::kLimit, kTrouble,
               "the tool is stopped at its limit: workspace, speed, force or depth"},
    EventWords{Event::kHold, kTrouble, "the tool is stopped (HOLD)"},
    EventWords{Event::kEstop, kTrouble, "emergency stop at the slave"},
    EventWords{Event::kModelChanged, kNews, "the slave's model was replaced"},
    EventWords{Event::kCommandRefused, kTrouble, "the slave rejected a command"}};

}  // namespace

std::vector<EventWords> InWords(const Events& events) {
  std::vector<EventWords> told;
  std::ranges::copy_if(kEventWords, std::back_inserter(told),
                       [&](const EventWords& known) { return events.Has(known.event); });
  return told;
}

}  // namespace palpate
