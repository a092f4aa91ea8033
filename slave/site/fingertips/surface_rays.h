// Where straight lines cross a closed surface.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate::site {

struct RayHit {
  double distance = 0;           // along the ray [m]
  Eigen::Vector3d n_O{0, 0, 0};  // outward unit normal of the triangle
};

// The first crossing ahead of `p_O` along the unit vector `direction_O`. O(N).
std::optional<RayHit> FirstHit(const SurfaceMesh& surface, const Eigen::Vector3d& p_O,
                               const Eigen::Vector3d& direction_O);

// Whether a point lies inside a closed surface: any ray from it crosses an odd number of times.
bool IsInside(const SurfaceMesh& surface, const Eigen::Vector3d& p_O);

}  // namespace palpate::site
