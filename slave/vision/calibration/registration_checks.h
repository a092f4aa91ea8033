// Parts of registrations: results of a robust fit, its checks, and the poses of a lens.
#pragma once

#include <vector>

#include "slave/vision/calibration/registration.h"
#include "slave/vision/calibration/robust_fit.h"

namespace palpate {

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
