// The edges by which a person recognises a shape: rims, sharp edges, and what bounds it from here.
#pragma once

#include <array>
#include <vector>

#include "master/view/viewpoint.h"
#include "shared/mesh/solid_mesh.h"

namespace palpate {

// Edges of `surface` that the viewer would see of it: open ones, those between a triangle that
// faces the viewer and one that does not, and sharp ones (more than 30 degrees) that face the
// viewer. Node pairs, the smaller first, in rising order.
std::vector<std::array<int, 2>> VisibleOutline(const SurfaceMesh& surface, const Viewpoint& view);

}  // namespace palpate
