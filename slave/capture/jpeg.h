// Pictures -> JPEG bytes for the video stream. Image codecs live in slave/capture only.
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace palpate {

// `image`: 1 or 3 channels, 8 bit, or 16 bit (its upper byte is taken). `quality` 1..100 (more is
// better and larger). Throws std::invalid_argument naming what is wrong: an empty picture, another
// type, a quality out of range; std::runtime_error if the codec fails.
std::string EncodeJpeg(const cv::Mat& image, int quality);

}  // namespace palpate
