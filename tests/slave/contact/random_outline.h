// Random bodies for tests: the same seed gives the same body.
#pragma once

#include <random>

#include "slave/mesh/outline.h"

namespace palpate {

// A star-shaped outline around the origin, radii 0.5 to 1, with 5 to 40 corners; every other one
// has a hole of radius 0.05 to 0.1. Concave corners and slivers abound.
Outline RandomOutline(std::mt19937* random);

// The same mesh with the elements of every loop numbered from another one on.
BoundaryMesh Renumbered(const BoundaryMesh& mesh, int shift);

}  // namespace palpate
