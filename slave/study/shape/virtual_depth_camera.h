// A virtual depth camera for surfaces (paper B, IV.C: the virtual Kinect).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"

namespace palpate::study {

// A capsule in the view, the occlusion by a finger: frame S [m].
struct Occluder {
  Eigen::Vector3d a{0, 0, 0}, b{0, 0, 0};  // ends of the capsule's axis
  double radius = 0;
};

// Returns the points of the surface that `camera` sees: one ray through each pixel's centre, its
// first hit, without hits on occluders; Gaussian noise along the ray. Frame S [m]. The same seed
// gives the same cloud. `camera.X_SD` etc. as in the scene.
std::vector<Eigen::Vector3d> ScanSurface(const DepthCamera& camera, const SurfaceMesh& surface,
                                         std::span<const Occluder> occluders, std::uint32_t seed);

// Occlusion by a finger: visible length of a finger behind its tip [m].
inline constexpr double kFingerLength = 0.06;

// Returns the capsule from the sphere of the tip back along the finger; `radius` [m] of both, frame
// S.
inline Occluder FingerCapsule(const Eigen::Isometry3d& X_SF, double radius) noexcept {
  return {X_SF.translation(), X_SF * Eigen::Vector3d(-kFingerLength, 0, 0), radius};
}

}  // namespace palpate::study
