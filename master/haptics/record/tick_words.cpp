#include "master/haptics/record/tick_words.h"

namespace palpate {

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

}  // namespace palpate
