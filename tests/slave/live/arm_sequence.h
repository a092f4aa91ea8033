// Commands, forces, stops, faults and settings in any order at the operator's port, and the targets
// that the arm receives.
#pragma once

#include "tests/support/choices.h"

namespace palpate {

// Throws std::logic_error if the arm receives a target while it must be held, a target that is
// farther or deeper than allowed, or one with another scale than the engagement's.
void RunArm(Choices choices);

}  // namespace palpate
