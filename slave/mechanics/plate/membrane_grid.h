// The nodes on which a round membrane's shape is given.
#pragma once

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// Rings of nodes around the centre: node 0 at the centre, ring k = 1..24 of radius k a / 24 with 6
// k nodes from the x axis on, counter-clockwise; the last ring is the clamped rim. Triangles face
// +z, all edges about a / 24 long. Frame O at the centre, z = 0 [m].
SurfaceMesh MembraneGrid(double radius);

}  // namespace palpate
