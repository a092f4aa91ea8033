// The estimator on paper C's membrane for tests, and the plate whose dots it sees.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/pipeline/points/surface_estimator.h"
#include "tests/slave/pipeline/points/membrane_scene.h"

namespace palpate::testing_fakes {

inline constexpr double kSigma = 2e-5;  // of a dot, per axis [m]
inline const Eigen::Vector3d kAway(0, 0, 0.01);

// A plate of other modes than the estimator's.
inline PlateLargeModel& FinerPlate() {
  static PlateLargeModel plate({kRadius, kThickness, kModulus, kNu, 0, 18});
  return plate;
}

inline Eigen::Isometry3d Askew() {
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();
  X_SO.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
  X_SO.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  return X_SO;
}

inline SurfaceEstimator& Large() {
  static SurfaceEstimator estimator(MembraneScene("plate-large"));
  estimator.Reset();
  return estimator;
}

}  // namespace palpate::testing_fakes
