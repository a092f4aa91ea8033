#include "master/haptics/tick_record.h"

#include <algorithm>

namespace palpate {
namespace {

FingerState ToolOf(const SlaveState& state) noexcept {
  FingerState tool;
  tool.p_S_contact = state.p_S_tip.cast<float>();
  if (state.force) tool.force = state.force->cast<float>();
  tool.in_contact = state.local_model.in_contact;
  tool.validity = state.validity;
  return tool;
}

}  // namespace

void RecordFingers(const SlaveState& state, TickRecord* record) noexcept {
  record->finger_count = std::max(state.finger_count, 1);
  record->fingers = state.fingers;
  if (state.finger_count == 0) record->fingers[0] = ToolOf(state);
}

}  // namespace palpate
