// Texts for actions of the operator, for logs and lists.
#pragma once

#include <string>
#include <vector>

#include "master/haptics/tick_record.h"

namespace palpate {

// Marks, tares, clutch and rendering changes between two ticks; may be empty.
std::vector<std::string> ActsInWords(const TickRecord& before, const TickRecord& now);

}  // namespace palpate
