// Texts for events of the slave.
#pragma once

#include <string_view>
#include <vector>

#include "shared/state/slave_state.h"

namespace palpate {

struct EventWords {
  enum class Weight { kUsual, kNews, kTrouble };
  Event event;
  Weight weight;
  std::string_view words;
};
std::vector<EventWords> InWords(const Events& events);

}  // namespace palpate
