// The inner face of a membrane before one camera.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/site/points/dent.h"
#include "slave/vision/stereo/rig.h"

namespace palpate::site {

struct MembraneView {
  // Grey levels: the clamp, the rubber.
  static constexpr float kBeyond = 150, kRubber = 190;

  Lens lens;
  Eigen::Isometry3d X_CO = Eigen::Isometry3d::Identity();  // p_C = X_CO p_O
  double radius = 0, thickness = 0;                        // [m]

  // Where the inner face's point that rests at p_O [m] is, frame O [m].
  [[nodiscard]] Eigen::Vector3d Place(const Eigen::Vector2d& p_O, const Dent& dent) const;
  // Plain rubber within the clamp, CV_32F of the lens's size, each pixel by its exact share.
  [[nodiscard]] cv::Mat PlainFace() const;
};

}  // namespace palpate::site
