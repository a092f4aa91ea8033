// Commands, forces, stops, faults and settings in any order at the operator's port: what the arm is
// told meanwhile.
#pragma once

#include "tests/support/choices.h"

namespace palpate {

// Throws std::logic_error where the arm is told to go though it must stand, farther or deeper than
// it may, or by another scale than the engagement's.
void RunArm(Choices choices);

}  // namespace palpate
