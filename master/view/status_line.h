// One line that says how it goes: state, rate, round trip, age, force.
#pragma once

#include <string>

#include "master/haptics/session.h"

namespace palpate {

// For example
//   `  12.3 s  FOLLOWING     1000 Hz  RTT 0.21 ms  age   3 ms   1.23 N [#######.............]
//   clamped`
// The bar is full at the force limit; what changed the force comes last, then what troubles the
// link. Unknown numbers are shown as `-`.
std::string FormatStatus(const Status& status);

}  // namespace palpate
