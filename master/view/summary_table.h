// The run as a person reads it.
#pragma once

#include <string>

#include "master/haptics/record/report.h"

namespace palpate {

// Two columns, a line per figure, ends with a newline.
std::string FormatSummary(const Report& report);

}  // namespace palpate
