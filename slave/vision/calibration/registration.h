// Camera pose in the slave's frame, from tip positions of the manipulator and their image points.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/vision/calibration/robust_fit.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

struct TipPlace {
  Eigen::Vector3d p_S{0, 0, 0};            // the tip [m]
  Eigen::Vector2d left_I{0, 0};            // right image point [px]
  std::optional<Eigen::Vector2d> right_I;  // in the right camera, if there is one
};

struct CameraRegistration {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();  // the (left) camera in S [m]
  double pixel = 0;                                        // RegisterPlane only [m]
  bool in_pixels = false;             // unit of the residuals below: px, else m
  std::vector<double> residuals;      // one per position; NaN: no ray or no intersection
  std::vector<bool> used;             // false: an outlier
  double rms = 0;                     // of those used
  double sigma_angle = 0;             // of the least certain axis [rad]
  double sigma_place = 0;             // of the camera's, least certain direction [m]; pair and lens
  std::vector<std::string> reasons;   // why it cannot be trusted; empty: it may
  std::vector<std::string> warnings;  // statements that a person must check at the camera
};

// Rigid fit (Kabsch) of the triangulated tips; needs right_I. All three exclude contradicting
// positions (least median of squares) and throw std::runtime_error with a sentence if there are too
// few positions for a pose. Collinear positions, a mirrored table, scatter and many outliers are
// reported in `reasons`. Coplanar positions also fit a mirrored table, with the camera on the other
// side of the plane: `warnings` states the assumed side.
CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places);
// Least squares of the image points; a second pose with a similar residual is reported in
// `reasons`. Camera frame z forward, x right, y down.
CameraRegistration RegisterLens(const Lens& lens, const std::vector<TipPlace>& places);
// A camera that looks straight down on the plane z = 0 of S: pixel size, rotation about z and
// shift. Camera frame as in CameraView: origin at the image centre, x right, y up. `size` of the
// image [px].
CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places);
// The same for the lens's undistorted images (LensWarp); `places` are distorted image points.
CameraRegistration RegisterLensPlane(const Lens& lens, const std::vector<TipPlace>& places);

struct LensPose {
  CameraGuess guess;
  double sum_of_squares = 0;  // of the misses [px^2]
};

// Local minima of the residual of the positions `which`, the least first: OpenCV's SQPnP and
// EPnP, and for a plane IPPE, which has both poses that look alike from afar; each refined. Empty:
// no pose.
std::vector<LensPose> LensPoses(const Lens& lens, const std::vector<TipPlace>& places,
                                const Indices& which);

// Distance of the projection of `place` from its image point [px]; NaN: no projection.
double LensMiss(const Lens& lens, const Eigen::Isometry3d& X_SC, const TipPlace& place);

}  // namespace palpate
