// What `check` says of `model.kind: auto`.
#pragma once

#include "slave/scene/scene.h"

namespace palpate {

// Prints the model that a quick study (about a second and a half) of the scene finds cheapest among
// those that meet its tolerance and rate, and why. Never throws: what cannot be studied is said.
void PrintAuto(const Scene& scene);

}  // namespace palpate
