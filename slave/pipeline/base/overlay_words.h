// Text in an image, legible on a page that shows it small.
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace palpate {

// One line into the upper left corner of an 8-bit colour image, as tall as a thirtieth of it, 12
// pixels at least; dark around, whatever the image shows there.
void DrawWords(const std::string& words, const cv::Scalar& colour, cv::Mat* picture);

}  // namespace palpate
