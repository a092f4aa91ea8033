// Points of the object's surface as the eyes see them: what dots, texture and depth pictures have
// in common, and what force is estimated from.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

// One point with an identity that lasts. Frame S.
struct SurfacePoint {
  int id = -1;                                           // the same point keeps it
  bool seen = false;                                     // false: the last place is repeated
  Eigen::Vector3d p_S_rest{0, 0, 0};                     // in the rest frame [m]
  Eigen::Vector3d p_S{0, 0, 0};                          // now [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of p_S [m^2]
};

struct SurfaceObservation {
  std::uint64_t sequence = 0;
  Time sensed_at{};
  bool found = false;  // enough points to say anything
  std::vector<SurfacePoint> points;
};

}  // namespace palpate
