// Triangles that cover a planar body, for pictures of a field in it. Frame O [m].
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/outline.h"

namespace palpate {

struct PlanarCover {
  std::vector<Eigen::Vector2d> inside;  // places inside of the body [m]
  // Indices of nodes, counter-clockwise: first the starts of the boundary elements, then `inside`.
  std::vector<std::array<int, 3>> triangles;
};

// About `places` places on a raster, none of them nearer to a boundary element than the element is
// long, so that the values of the boundary elements serve there. Fewer where the elements are long.
PlanarCover CoverOf(const BoundaryMesh& mesh, int places);

}  // namespace palpate
