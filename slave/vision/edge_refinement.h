// From a contour that is right to a few pixels to points on the edge, right to a small part of one.
#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slave/vision/closed_curve.h"
#include "slave/vision/grey.h"

namespace palpate {

struct RefinementOptions {
  double spacing = 4;  // of the points along the contour [px]
  double reach = 6;    // how far the edge may lie from the contour [px]
};

// Points on the object's edge [px], one about every `spacing` along `contour`, in its direction.
//
// At each, the profile of grey levels along the normal (averaged over 5 px along the contour, so
// that noise and texture do not count) is differentiated; the edge is the centroid of the
// derivative within +-3 px of its peak, the window being moved until it is centred on the edge.
// That is unbiased for every symmetric blur (E. P. Lyvers et al., Subpixel measurements using a
// moment-based edge operator, PAMI 11, 1989, has the same in two dimensions). The edge has the
// polarity (dark to light or light to dark) of most of the contour. Points without a clear edge,
// at corners, or where the edge jumps from its neighbours', are left out.
Curve RefineContour(const cv::Mat& image, const GreyFormat& format, CurveView contour,
                    const RefinementOptions& options = {});

}  // namespace palpate
