// Where the middle of a tilted dot's picture lies, which is not the picture of its middle.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "slave/vision/stereo/rig.h"

namespace palpate {

// Centroid of the picture of a flat disc minus the picture of its centre [px]. A line l of the
// picture (a plane through the eye with normal l) touches the disc's edge where
//   (l . c)^2 = r^2 (l . l - (l . n)^2),
// so the dual conic is c c' - r^2 (I - n n'), and the ellipse's centre is its last column. For a
// pinhole this is exact (reference g: x_e = -r^2 sin cos / (Z^2 - r^2 sin^2)); the lens's
// distortion is taken as it is at the ellipse's centre. `p_C` centre [m], `n_C` unit normal, camera
// frame, `radius` [m]. nullopt: behind the camera, or the disc reaches the eye's plane.
std::optional<Eigen::Vector2d> CircleCentroidBias(const Lens& lens, const Eigen::Vector3d& p_C,
                                                  const Eigen::Vector3d& n_C,
                                                  double radius) noexcept;

}  // namespace palpate
