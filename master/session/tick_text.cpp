#include "master/session/tick_text.h"

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
    EventWords{Event::kModelChanged, kNews, "the slave's model was replaced"},
    EventWords{Event::kCommandRefused, kTrouble, "the slave rejected a command"}};

}  // namespace

std::vector<std::string> ActsInWords(const TickRecord& before, const TickRecord& now) {
  std::vector<std::string> lines;
  for (auto mark = before.marks; mark < now.marks; ++mark) {
    lines.push_back("mark " + std::to_string(mark + 1));
  }
  if (now.clutched != before.clutched) {
    lines.emplace_back(now.clutched ? "the clutch is open: the operator is disengaged"
                                    : "the clutch is closed: the operator may engage");
  }
  if (now.device.fault != before.device.fault) {
    const std::string fault = FaultInWords(now.device);
    lines.push_back("device: " + (fault.empty() ? "good readings again" : fault));
  }
  if (now.render != before.render) {
    lines.push_back("rendering " + std::string(ToString(now.render)));
  }
  if (now.tare_state != before.tare_state && !InWords(now.tare_state).empty()) {
    lines.emplace_back(InWords(now.tare_state));
  }
  return lines;
}

std::vector<EventWords> InWords(const Events& events) {
  std::vector<EventWords> found;
  std::ranges::copy_if(kEventWords, std::back_inserter(found),
                       [&](const EventWords& known) { return events.Has(known.event); });
  return found;
}

}  // namespace palpate
