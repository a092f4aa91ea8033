// The outline of an object as a polygon, for the set-up of a scene.
#pragma once

#include <opencv2/core/mat.hpp>

#include "slave/vision/closed_curve.h"

namespace palpate {

struct FoundOutline {
  Curve polygon;     // [px]; corners, and points along bent parts
  double clear = 0;  // part of it along which there is a clear edge [-]
};

// Returns the object's edge near the polygon `near` [px] drawn by a person (empty: anywhere), found
// like by FindRestContour. Straight sides are fitted to all points of the edge along them, and meet
// in corners. Throws std::runtime_error: no such edge; std::invalid_argument: one or two points, an
// image that cannot be used.
FoundOutline FindOutlineNear(const cv::Mat& image, CurveView near);

}  // namespace palpate
