// Camera pose in the slave's frame, from tip positions of the manipulator and their image points.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/vision/stereo/rig.h"

namespace palpate {

struct TipPlace {
  Eigen::Vector3d p_S{0, 0, 0};            // the tip [m]
  Eigen::Vector2d left_I{0, 0};            // image point in the left camera [px]
  std::optional<Eigen::Vector2d> right_I;  // in the right camera, if there is one
};

struct CameraRegistration {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();  // the (left) camera in S [m]
  double pixel = 0;                                        // RegisterPlane only [m]
  std::vector<double> residuals;                           // one per position [m]
  std::vector<bool> used;                                  // false: an outlier
  double rms = 0;                                          // of those used [m]
  double sigma_angle = 0;  // standard deviation of the rotation about the least certain axis [rad]
  // Standard deviation of the camera's position in the least certain direction [m].
  double sigma_place = 0;
  std::vector<std::string> reasons;  // why it cannot be trusted; empty: it may
};

// Both exclude contradicting positions and throw std::runtime_error with a sentence if a position
// has no finite numbers or no intersection of rays, or if there are
// too few positions for a pose. A small spread of the positions in some direction, a mirrored
// table, scatter and many outliers are reported in `reasons`. Standard deviations are those of the
// jackknife (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 11).

// Rigid fit of the triangulated tips; needs right_I. Camera frame z forward, x right, y down.
// Residual: distance of the tips. Coplanar positions are rejected, because a mirrored table fits
// them as well.
CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places);
// Registers a camera that looks straight down on the plane z = 0 of S: pixel size, rotation about z
// and shift. Camera frame as in CameraView: origin at the image centre, x right, y up. `size` of
// the image [px]. Residual: distance in the plane.
CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places);

}  // namespace palpate
