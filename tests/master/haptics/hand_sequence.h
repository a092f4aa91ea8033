// States, patches, settings, requests and deaths in any order at the haptic loop: the rendered
// force meanwhile.
#pragma once

#include "tests/support/choices.h"

namespace palpate {

// Throws std::logic_error where the hand gets more force, change or energy than the master allows.
void RunHand(Choices choices);

}  // namespace palpate
