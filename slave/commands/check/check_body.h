// What `check` says of membranes and volumes: the mesh and its quality, the model, a press.
#pragma once

#include "slave/scene/scene.h"

namespace palpate {

// Prints the object, its mesh, the model and a press. Throws std::invalid_argument: the scene
// cannot be computed.
void PrintBody(const Scene& scene);
// Prints the report of a scene without senses. Throws std::invalid_argument: the scene cannot be
// computed.
void CheckBody(const Scene& scene);

}  // namespace palpate
