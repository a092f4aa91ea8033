// Remarks on the files of a scene, which every command that loads it prints.
#pragma once

#include <string>
#include <vector>

#include "slave/scene/scene.h"

namespace palpate {

// Lists parts of a mesh file that are unused or look wrong, and implausible numbers: the object's
// size and material, gravity (shared/text/plausible.h), a tool wider than the
// object, a pixel larger than 5 mm, a baseline larger than the distance. A file that cannot be read
// has no remarks: it is refused where it is used.
std::vector<std::string> RemarksOn(const Scene& scene);
// Writes them to the log as warnings.
void LogRemarks(const Scene& scene);

}  // namespace palpate
