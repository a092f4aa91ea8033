// What `check` says of membranes and volumes: the mesh and its quality, the model, a press.
#pragma once

#include "shared/scene/scene.h"

namespace palpate {

// Prints the report. Throws std::invalid_argument: the scene cannot be computed.
void CheckBody(const Scene& scene);

}  // namespace palpate
