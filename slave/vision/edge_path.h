// A closed edge around a point: the best of all that surround it; and the quality of the edge along
// a closed curve.
#pragma once

#include <opencv2/core/mat.hpp>

#include "slave/vision/closed_curve.h"

namespace palpate {

struct EdgePath {
  Curve curve;  // [px]
  double strength =
      0;  // mean along the curve of the edge strength across it, each point at most 1 [-]
  double closedness = 0;  // part of the curve along which there is an edge of the right sign
};

// Searches `image` (8 bit grey) for a closed edge, light to dark or dark to light all round, around
// the centre of `guide` and similar to `guide`, up to 2.2 times larger or smaller, which may vary
// along it. It uses dynamic programming over the rays from the centre (A. A. Amini, T. E. Weymouth
// and R. C. Jain, PAMI 12, 1990), with gradients limited to 1, so that one strong edge does not
// outweigh many weak ones. Empty: no guide, or it is outside of the image. About 5 ms.
EdgePath FollowEdgeAround(const cv::Mat& image, CurveView guide);
// Measures `curve` itself, with the better sign.
EdgePath MeasureEdge(const cv::Mat& image, CurveView curve);

}  // namespace palpate
