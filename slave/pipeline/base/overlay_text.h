// Draws text and lines into an image, so that they are seen on any image and where a page shows
// the image small.
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace palpate {

// Draws one line of text into the upper left corner of an 8-bit colour image. Its height is a
// thirtieth of the image's, at least 12 pixels. A dark outline keeps it legible on any image.
void DrawText(const std::string& text, const cv::Scalar& colour, cv::Mat* image);

// Calls `draw(colour, thickness)` twice: dark and two pixels wider, then in `colour`.
template <class Draw>
void OnAnyImage(const cv::Scalar& colour, int thickness, const Draw& draw) {
  draw(cv::Scalar(20, 20, 20), thickness + 2);
  draw(colour, thickness);
}

// Draws an arrow [px] with marks across it at its length minus and plus `sigma` [px]. An arrow
// shorter than a pixel is not drawn, nor are marks for a `sigma` below half a pixel.
void DrawArrow(const cv::Point2d& from, const cv::Point2d& to, double sigma,
               const cv::Scalar& colour, cv::Mat* image);

}  // namespace palpate
