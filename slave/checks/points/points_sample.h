// PointsSample is the input of the checks of measured points, from one pair of images or one depth
// image.
#pragma once

#include <opencv2/core/mat.hpp>

#include "slave/vision/stereo/surface_points.h"

namespace palpate {

struct PointsSample {
  const cv::Mat& left;   // or the depth image
  const cv::Mat& right;  // empty: a depth image
  // The points. Checks set the uncertainties of their positions, distances and time.
  SurfaceObservation& seen;
};

}  // namespace palpate
