// What a finger hides from a camera.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate::study {

// How much is seen of a finger behind its tip [m].
inline constexpr double kFingerLength = 0.06;

// From the sphere of the tip back along the finger; `radius` [m] of both, frame S.
inline Occluder FingerCapsule(const Eigen::Isometry3d& X_SF, double radius) noexcept {
  return {X_SF.translation(), X_SF * Eigen::Vector3d(-kFingerLength, 0, 0), radius};
}

}  // namespace palpate::study
