// Measured points of the object's surface: the common output of dots, texture and depth images, and
// the input of the force estimation.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "shared/state/verdict.h"

namespace palpate {

// SurfacePoint is a point with a permanent identity. Frame S.
struct SurfacePoint {
  int id = -1;                                           // identity of the point
  bool seen = false;                                     // false: the last position is repeated
  Eigen::Vector3d p_S_rest{0, 0, 0};                     // in the rest frame [m]
  Eigen::Vector3d p_S{0, 0, 0};                          // present position [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of p_S [m^2]
  // The members below are those of stereo pairs; sigma 0: not measured by a pair.
  Eigen::Vector2d left_I{0, 0}, right_I{0, 0};  // image points [px]
  double sigma_px = 0;  // sigma of the image points, per axis, from the images [px]
  double miss_px = 0;   // Triangulated::miss_px
  // The scatter at rest equals the image noise, so noise is the only error. Errors that are fixed
  // to the pixels, as by compression, do not scatter.
  bool errs_by_noise_alone = true;
};

// `Verdict`: of the points, without a model.
struct SurfaceObservation : Verdict {
  SurfaceObservation() : Verdict{Validity::kValid} {}

  std::uint64_t sequence = 0;
  Time sensed_at{};
  bool found = false;  // enough points for an estimate
  std::vector<SurfacePoint> points;
  // rms of the ray distances minus those at rest [px]; 0: not a stereo pair.
  double epipolar_px = 0;
  double scale_error = 0;  // relative standard deviation of the scale of all distances [-]
  double place_error =
      0;  // at rest, along the surface, relative to the distance of neighbours [-]; 0: unknown
  double skew = 0;  // time between right and left image by their timestamps [s]
  // Standard deviation of the time relative to the timestamps [pair periods]; 0: not a stereo pair.
  double moment_sigma = 0;
};

}  // namespace palpate
