// States, patches, settings, requests and deaths in any order at the haptic loop: the rendered
// force meanwhile.
#pragma once

#include "tests/support/choices.h"

namespace palpate {

// Throws std::logic_error if the device gets more force, more change of force or more energy than
// the master allows.
void RunHand(Choices choices);

}  // namespace palpate
