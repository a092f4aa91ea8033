// The inner face of a membrane before one camera.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/site/stereo/dent.h"
#include "slave/vision/stereo/rig.h"

namespace palpate::site {

struct MembraneView {
  static constexpr float kBeyond = 70, kRubber = 190;  // grey levels: the clamp, the rubber

  Lens lens;
  Eigen::Isometry3d X_CO = Eigen::Isometry3d::Identity();  // p_C = X_CO p_O
  double radius = 0, thickness = 0;                        // [m]

  // Picture [px] of the inner face's point that rests at p_O [m]. nullopt: the lens does not see
  // it.
  [[nodiscard]] std::optional<Eigen::Vector2d> See(const Eigen::Vector2d& p_O,
                                                   const Dent& dent) const;
  // Plain rubber within the clamp, CV_32F of the lens's size, each pixel by its exact share.
  [[nodiscard]] cv::Mat PlainFace() const;
};

}  // namespace palpate::site
