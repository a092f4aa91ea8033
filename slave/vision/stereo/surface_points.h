// Points of the object's surface as the eyes see them: what dots, texture and depth pictures have
// in common, and what force is estimated from.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "shared/state/failed_check.h"

namespace palpate {

// One point with an identity that lasts. Frame S.
struct SurfacePoint {
  int id = -1;                                           // the same point keeps it
  bool seen = false;                                     // false: the last place is repeated
  Eigen::Vector3d p_S_rest{0, 0, 0};                     // in the rest frame [m]
  Eigen::Vector3d p_S{0, 0, 0};                          // now [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of p_S [m^2]
  // What two eyes add; sigma 0: it was not seen by two.
  Eigen::Vector2d left_I{0, 0}, right_I{0, 0};  // in their pictures [px]
  double sigma_px = 0;                          // of these, per axis, as the pictures show it [px]
  double miss_px = 0;                           // Triangulated::miss_px
  // It scatters at rest as that noise says, so that what scatters is all that errs: errors that are
  // fixed to the pixels, as compression's, need not.
  bool errs_by_noise_alone = true;
};

struct SurfaceObservation {
  std::uint64_t sequence = 0;
  Time sensed_at{};
  bool found = false;  // enough points to say anything
  std::vector<SurfacePoint> points;
  // What speaks against what the points tell, and in words: one clause that lives on.
  FailedCheck check = FailedCheck::kNone;
  std::string_view why;
  double epipolar_px = 0;  // rms of the rays' misses less those at rest [px]; 0: not of two eyes
  double scale_error = 0;  // by which their distances may be wrong, a share [-]
  // The first doubt stays.
  void Flag(FailedCheck failed, std::string_view clause) noexcept {
    if (check != FailedCheck::kNone) return;
    check = failed;
    why = clause;
  }
  double skew = 0;  // of two eyes' pictures, right minus left, as their stamps tell [s]
  // One sigma of how far their moment may be from what the stamps tell [times from pair to pair];
  // 0: not of two eyes.
  double moment_sigma = 0;
};

}  // namespace palpate
