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

// Parts of registrations: results of a robust fit, its checks, and the poses of a lens.
Indices AllIndices(std::size_t count);
Indices UsedOf(const CameraRegistration& r);

// Positions and their principal directions.
struct PlaceCloud {
  Eigen::Vector3d mean{0, 0, 0};
  Eigen::Vector3d extents{0, 0, 0};  // root mean square along the directions, rising [m]
  Eigen::Vector3d normal{0, 0, 1};   // the direction of the smallest extent
};
PlaceCloud CloudOf(const Indices& used, const std::vector<TipPlace>& places);

CameraRegistration RegistrationOf(const RobustFit& fit, bool in_pixels);

// Each adds to r->reasons. `fewest` positions determine a pose; `rms_m` [m].
void CheckPlaces(const Eigen::Vector3d& extents, std::size_t fewest, CameraRegistration* r);
void CheckScatter(double rms_m, const Eigen::Vector3d& extents, CameraRegistration* r);
// `mirrored_rms`: residual of the used positions for the mirrored table, in the unit of r->rms.
void CheckMirror(double mirrored_rms, const std::vector<TipPlace>& places, CameraRegistration* r);
// A position above the plane has the image of another point of the plane.
void CheckHeights(const Indices& used, const std::vector<TipPlace>& places,
                  const Eigen::Vector3d& extents, CameraRegistration* r);
[[noreturn]] void RefuseTooFew(std::size_t usable, std::size_t fewest);

struct LensPose {
  CameraGuess guess;
  double sum_of_squares = 0;  // of the misses [px^2]
};

// Poses with the least residual of the positions `which`, the best first: from OpenCV's SQPnP and
// from its result mirrored as a plane that looks alike from afar (Oberkampf, DeMenthon and Davis,
// Computer Vision and Image Understanding 63, 1996); a different local minimum comes second. Empty:
// no pose.
std::vector<LensPose> LensPoses(const Lens& lens, const std::vector<TipPlace>& places,
                                const Indices& which);

// Distance of the projection of `place` from its image point [px]; NaN: no projection.
double LensMiss(const Lens& lens, const Eigen::Isometry3d& X_SC, const TipPlace& place);

}  // namespace palpate
