// States, patches, settings, requests and deaths in any order at the haptic loop: the rendered
// force meanwhile.
#pragma once

#include "tests/support/choices.h"

namespace palpate {

// What the master allows: force, change of force, and energy for nothing.
inline constexpr double kForceLimit = 3.3;    // [N]
inline constexpr double kSlewLimit = 0.2;     // [N/ms]
inline constexpr double kEnergyLimit = 1e-3;  // [J]

// Throws std::logic_error if the device gets more force, more change of force or more energy than
// the master allows.
void RunHand(Choices choices);

}  // namespace palpate
