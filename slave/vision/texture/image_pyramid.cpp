#include "slave/vision/texture/image_pyramid.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include <opencv2/imgproc.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kMinSize = 32;  // [px] [tuned: TheOtherCamerasImageMayBeLarger]

// BT.601 in 16.16 fixed point.
void GreyRow(const std::uint8_t* bgr, std::uint8_t* grey, int width) {
  for (int x = 0; x < width; ++x, bgr += 3) {
    grey[x] = static_cast<std::uint8_t>(
        (7471U * bgr[0] + 38470U * bgr[1] + 19595U * bgr[2] + 32768U) >> 16);
  }
}

// Halves an image by the mean of 2 x 2 pixels; an odd last row or column is dropped.
void Halve(const cv::Mat& from, cv::Mat& to) {
  for (int y = 0; y < to.rows; ++y) {
    const auto *a = from.ptr<std::uint8_t>(2 * y), *b = from.ptr<std::uint8_t>(2 * y + 1);
    auto* out = to.ptr<std::uint8_t>(y);
    for (int x = 0; x < to.cols; ++x) {
      out[x] =
          static_cast<std::uint8_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2U) >> 2);
    }
  }
}

}  // namespace

ImagePyramid::ImagePyramid(const cv::Mat& first, int levels) : type_(first.type()) {
  if (first.dims != 2 || (type_ != CV_8UC1 && type_ != CV_8UC3)) {
    throw std::invalid_argument("image of texture: expected 8 bit grey or BGR");
  }
  if (first.cols < kMinSize || first.rows < kMinSize) {
    throw std::invalid_argument("image of texture: " + std::to_string(first.cols) + " x " +
                                std::to_string(first.rows) + " px: expected 32 px and more");
  }
  Require(levels >= 1, "levels", levels, ">= 1");
  for (cv::Size size = first.size();
       static_cast<int>(levels_.size()) < levels && std::min(size.width, size.height) >= kMinSize;
       size = {size.width / 2, size.height / 2}) {
    levels_.emplace_back(size, CV_8UC1);
  }
  Read(first);
}

bool ImagePyramid::Read(const cv::Mat& image) noexcept {
  cv::Mat& fine = levels_.front();
  if (image.dims != 2 || image.type() != type_ || image.data == nullptr ||
      image.cols != fine.cols || image.rows != fine.rows) {
    return false;
  }
  for (int y = 0; y < fine.rows; ++y) {
    if (type_ == CV_8UC3) {
      GreyRow(image.ptr<std::uint8_t>(y), fine.ptr<std::uint8_t>(y), fine.cols);
    } else {
      std::memcpy(fine.ptr(y), image.ptr(y), static_cast<std::size_t>(fine.cols));
    }
  }
  for (std::size_t l = 1; l < levels_.size(); ++l) Halve(levels_[l - 1], levels_[l]);
  return true;
}

std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& image, int count, int edge,
                                           double apart) {
  const bool readable = image.dims == 2 && (image.type() == CV_8UC1 || image.type() == CV_8UC3);
  const int rim = edge / 2 + 2;
  if (!readable || count < 1 || edge < 1 || image.cols <= 2 * rim || image.rows <= 2 * rim) {
    return {};
  }
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat inside = cv::Mat::zeros(grey.size(), CV_8UC1);
  inside(cv::Rect(rim, rim, grey.cols - 2 * rim, grey.rows - 2 * rim)).setTo(255);
  constexpr double kOfTheBest = 0.01;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, count, kOfTheBest, apart, inside, edge);
  std::vector<Eigen::Vector2d> centres;
  centres.reserve(corners.size());
  for (const cv::Point2f& corner : corners) centres.emplace_back(corner.x, corner.y);
  return centres;
}

}  // namespace palpate
