// Where a camera stands in the slave's frame, from places the manipulator carried the tool's tip to
// and where the pictures show it.
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
  Eigen::Vector2d left_I{0, 0};            // its picture [px]
  std::optional<Eigen::Vector2d> right_I;  // in the right camera, if there is one
};

struct CameraRegistration {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();  // the (left) camera in S [m]
  double pixel = 0;                                        // RegisterPlane only [m]
  bool in_pixels = false;                                  // the unit of what follows: px, else m
  std::vector<double> residuals;      // one per place; NaN: no ray or no meeting
  std::vector<bool> used;             // false: an outlier
  double rms = 0;                     // of those used
  double sigma_angle = 0;             // of the least certain axis [rad]
  double sigma_place = 0;             // of the camera's, least certain direction [m]; pair and lens
  std::vector<std::string> reasons;   // why it cannot be trusted; empty: it may
  std::vector<std::string> warnings;  // what only somebody who sees the camera can check
};

// Rigid fit (Kabsch) of the triangulated tips. Places need right_I. All three leave out the places
// that contradict the others (least median of squares) and throw std::runtime_error in words where
// there are too few places to define a pose; places on a line, a mirrored table, scatter and many
// outliers are told in `reasons`. Places on a plane fit a mirrored table as well, with the camera
// on the plane's other side: `warnings` says on which it is taken to be.
CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places);
// Least squares of the pictures; a second pose that fits as well is told in `reasons`. Camera frame
// z forward, x right, y down.
CameraRegistration RegisterLens(const Lens& lens, const std::vector<TipPlace>& places);
// A camera straight above the plane z = 0 of S: pixel size, turn about z and shift. Camera frame as
// of CameraView: origin in the picture's centre, x right, y up. `size` of the picture [px].
CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places);
// The same for the lens's straight pictures (LensWarp); `places` as seen, before that.
CameraRegistration RegisterLensPlane(const Lens& lens, const std::vector<TipPlace>& places);

}  // namespace palpate
