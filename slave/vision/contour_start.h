// Finds the object in a picture without being told where it is.
#pragma once

#include <opencv2/core/mat.hpp>

#include "slave/vision/closed_curve.h"

namespace palpate {

// Outline [px] of the object in `picture` (8 bit grey): of all closed regions that some threshold
// cuts out, darker or brighter, whole in the picture, the one whose outline has the strongest edge
// for its size and is most nearly convex. A tool that enters from the picture's border is cut off
// first: `tool_width` [px], 0 where there is none. Regions below 0.1 % or above 70 % of the picture
// are no objects. Throws std::runtime_error: there is none. About 50 ms at 640 x 480.
Curve FindObject(const cv::Mat& picture, double tool_width);

}  // namespace palpate
