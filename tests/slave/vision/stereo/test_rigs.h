// Pairs of cameras for tests.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "slave/vision/stereo/rig.h"

namespace palpate {

inline Lens TestLens(const std::array<double, 5>& distortion = {}) {
  return {800, 800, 320, 240, distortion, {640, 480}};
}

// A lens as in scenes: its principal point is the centre of the image.
inline Lens SceneLens() {
  return {800, 800, 319.5, 239.5, {}, {640, 480}};
}

// X_OC of a camera 30 mm to one side of O's z axis, turned towards O's origin from 250 mm ahead of
// it; `side`: -1 left, 1 right.
inline Eigen::Isometry3d VergedPose(double side) {
  Eigen::Isometry3d X_OC = Eigen::Isometry3d::Identity();
  X_OC.translation() << side * 0.03, 0, -0.25;
  X_OC.linear() = Eigen::AngleAxisd(-side * std::atan2(0.03, 0.25), Eigen::Vector3d::UnitY())
                      .toRotationMatrix();
  return X_OC;
}

inline StereoRig VergedRig(const Lens& lens) {
  StereoRig rig;
  rig.left = rig.right = lens;
  rig.X_RL = VergedPose(1).inverse() * VergedPose(-1);
  return rig;
}
inline StereoRig VergedTestRig(const std::array<double, 5>& distortion = {}) {
  return VergedRig(TestLens(distortion));
}

}  // namespace palpate
