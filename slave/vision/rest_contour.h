// The object's outline in the first image: found, settled on by the snake (paper A, eq. 2), and
// measured to a small part of a pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/grey.h"

namespace palpate {

// Outline of the object at rest, in its orientation in the image [px].
struct RestContour {
  Curve outline;  // the snake's control points
  Curve edge;     // points on the edge, see RefineContour; gaps where it is not clear
};

// Starts the snake at `options.start` (whose size may be wrong by 40 %) or, without one, at the
// result of FindObject, lets it settle and refines it. `tool_width` [px], 0: no tool.
// `clockwise_I`: orientation in the image. Throws std::runtime_error: no contour found, an image
// too small, the contour collapsed, intersected itself or found no edge.
RestContour FindRestContour(const ContourTracking& options, const cv::Mat& first,
                            const GreyFormat& format, double tool_width, bool clockwise_I);

// Finds the object in an image without a start: the outline [px] of the object in `image` (8 bit
// grey). Among all closed regions that some threshold separates, darker or brighter, completely in
// the image, it selects the one whose outline has the strongest edge for its size and is most
// nearly convex. A tool that enters from the image border is cut off first: `tool_width` [px], 0:
// none. Regions below 0.1 % or above 70 % of the image are not objects. Throws std::runtime_error:
// there is none. About 50 ms at 640 x 480.
Curve FindObject(const cv::Mat& image, double tool_width);

struct RefinementOptions {
  double spacing = 4;  // of the points along the contour [px]
  int reach = 6;       // largest distance of the edge from the contour [px]
};

// Refines a contour that is accurate to a few pixels. Returns points on the object's edge [px],
// accurate to a small part of a pixel: one about every `spacing` along `contour`, in its direction.
//
// At each it is the steepest edge of the EdgeProfile along the normal. The edge has the
// polarity (dark to light or light to dark) of most of the contour. Points without a clear edge,
// at corners, or where the edge jumps from its neighbours', are left out.
Curve RefineContour(const cv::Mat& image, const GreyFormat& format, CurveView contour,
                    const RefinementOptions& options = {});

}  // namespace palpate
