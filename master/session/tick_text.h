// Texts for actions of the operator, for logs and lists.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "master/haptics/tick_record.h"
#include "shared/state/slave_state.h"

namespace palpate {

// Marks, tares, clutch and rendering changes between two ticks; may be empty.
std::vector<std::string> ActsInWords(const TickRecord& before, const TickRecord& now);

// Texts for events of the slave.
struct EventWords {
  enum class Weight { kUsual, kNews, kTrouble };
  Event event;
  Weight weight;
  std::string_view words;
};
std::vector<EventWords> InWords(const Events& events);

}  // namespace palpate
