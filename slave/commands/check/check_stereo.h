// What `check` says of scenes with two cameras or depth pictures: where they stand, what they see,
// how exact and how fast.
#pragma once

#include "slave/scene/scene.h"

namespace palpate {

// Prints the report. Throws std::invalid_argument or std::runtime_error: the scene cannot be seen
// or computed.
void CheckStereo(const Scene& scene);

}  // namespace palpate
