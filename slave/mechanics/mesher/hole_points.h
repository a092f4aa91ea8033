// Where a mesher must not fill.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// A point in every cavity of a closed surface that CheckMesh has turned [m]: half way along the
// normal of the cavity's largest triangle to the next triangle. O(parts x triangles).
std::vector<Eigen::Vector3d> HolePoints(const SurfaceMesh& surface);

}  // namespace palpate
