// Whether supports fix a body.
#pragma once

#include <array>
#include <vector>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// Throws std::invalid_argument unless the held components fix all six rigid motions of every
// connected part of the mesh. O(N).
void RequireSupported(const SolidMesh& mesh, const std::vector<std::array<bool, 3>>& held);

}  // namespace palpate
