// What `check` says of scenes with fingertips: what senses, what it tells, how exact and how fast.
#pragma once

#include "slave/scene/scene.h"

namespace palpate {

// Prints the report. Throws std::invalid_argument or std::runtime_error: the scene cannot be sensed
// or computed.
void CheckTactile(const Scene& scene);

}  // namespace palpate
