// Remarks on the object and the tool of a scene.
#pragma once

#include <string>
#include <vector>

#include "slave/scene/scene.h"

namespace palpate {

// Lists parts of a mesh that are unused or look wrong, and implausible numbers: for the object's
// size and material and for gravity (shared/text/plausible.h), and a tool wider than the object.
// Throws std::invalid_argument: a mesh file that cannot be read.
std::vector<std::string> RemarksOnObject(const Scene& scene);

}  // namespace palpate
