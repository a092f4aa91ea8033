// Pairs of cameras for tests.
#pragma once

#include "slave/vision/stereo/rig.h"

namespace palpate {

inline Lens TestLens(const std::array<double, 5>& distortion = {}) {
  return {800, 800, 320, 240, distortion, {640, 480}};
}

// 60 mm apart, verged on the point 250 mm ahead of their middle.
inline StereoRig VergedTestRig(const std::array<double, 5>& distortion = {}) {
  StereoRig rig;
  rig.left = rig.right = TestLens(distortion);
  const double turn = 2 * std::atan2(0.03, 0.25);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()).toRotationMatrix();  // R_RL
  const Eigen::Matrix3d half =
      Eigen::AngleAxisd(turn / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  rig.X_RL.linear() = R;
  rig.X_RL.translation() = -(half * Eigen::Vector3d(0.06, 0, 0));
  return rig;
}

}  // namespace palpate
