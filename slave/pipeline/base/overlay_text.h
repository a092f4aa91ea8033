// Draws text into an image, legible where a page shows the image small.
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace palpate {

// Draws one line of text into the upper left corner of an 8-bit colour image. Its height is a
// thirtieth of the image's, at least 12 pixels. A dark outline keeps it legible on any image.
void DrawText(const std::string& text, const cv::Scalar& colour, cv::Mat* image);

}  // namespace palpate
