#include "slave/capture/jpeg.h"

#include <stdexcept>
#include <vector>

#include <opencv2/imgcodecs.hpp>

namespace palpate {

std::string EncodeJpeg(const cv::Mat& image, int quality) {
  const bool known = !image.empty() && (image.channels() == 1 || image.channels() == 3) &&
                     (image.depth() == CV_8U || image.depth() == CV_16U);
  if (!known) {
    throw std::invalid_argument("picture of " + std::to_string(image.cols) + " x " +
                                std::to_string(image.rows) + " px, " +
                                std::to_string(image.channels()) +
                                " channels: accepted for JPEG are 1 or 3 channels of 8 or 16 bit");
  }
  if (quality < 1 || quality > 100) {
    throw std::invalid_argument("quality = " + std::to_string(quality) + ": accepted is 1 to 100");
  }
  cv::Mat bytes_per_channel = image;
  if (image.depth() == CV_16U) image.convertTo(bytes_per_channel, CV_8U, 1.0 / 257);
  std::vector<unsigned char> coded;
  if (!cv::imencode(".jpg", bytes_per_channel, coded, {cv::IMWRITE_JPEG_QUALITY, quality})) {
    throw std::runtime_error("the JPEG codec refused a picture of " + std::to_string(image.cols) +
                             " x " + std::to_string(image.rows) + " px");
  }
  return {coded.begin(), coded.end()};
}

}  // namespace palpate
