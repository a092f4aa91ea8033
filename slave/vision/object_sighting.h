// ObjectSighting contains the measurements of the object's edge in one image: its motion since the
// first image, its indentation, and the quality of the image.
#pragma once

#include <Eigen/Core>

#include "slave/vision/rest_edge.h"

namespace palpate {

// Result for one image.
struct ObjectSighting {
  bool known = false;      // enough of the edge, in every direction
  ImageMotion motion;      // from the first image into this one; the last one if unknown
  double sigma_px = 0;     // of the motion, where the tip is, both directions together
  double residual_px = 0;  // residual of the points that agree, rms
  int places = 0, agreeing = 0;
  // Number of consecutive points whose edge deviates to one side, as by an occlusion.
  int apart = 0;
  // Width of the edges along x or y, the larger: 1: as in the first image; and there 1: sharp.
  double sharpness = 1, sharpness_at_rest = 1;
  double exposure = 0;  // RestEdge::exposure, the median
  // Displacement of the contact according to the edge next to it, in O [px], with its covariance
  // [px^2]. Absent if it is hidden, and with the tool far from the surface.
  bool indentation_known = false;
  Eigen::Vector2d indentation_O{0, 0};
  Eigen::Matrix2d indentation_covariance = Eigen::Matrix2d::Zero();
  // Uncertainty of the tip position due to image motion, compensated or not [px^2].
  Eigen::Matrix2d motion_covariance = Eigen::Matrix2d::Zero();
};

}  // namespace palpate
