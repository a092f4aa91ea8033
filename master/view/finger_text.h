// A fingertip's state and numbers as text.
#pragma once

#include <string>

#include "shared/state/slave_state.h"

namespace palpate {

// `value` with three significant digits: 0.412, 12.5, 1e+06.
std::string Readable(double value);
// Returns text: `0.41 N`, `free`, `force unknown (tracking lost)`.
std::string InWords(const FingerState& finger);

}  // namespace palpate
