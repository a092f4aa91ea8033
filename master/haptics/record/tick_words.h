// What the operator did beside moving the hand, in words, for logs and lists.
#pragma once

#include <string>
#include <vector>

#include "master/haptics/record/tick_record.h"

namespace palpate {

// Between two ticks: marks, tares, the clutch, how forces are rendered. Empty: nothing.
std::vector<std::string> ActsInWords(const TickRecord& before, const TickRecord& now);

}  // namespace palpate
