#include "slave/pipeline/base/overlay_text.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace palpate {

void DrawText(const std::string& text, const cv::Scalar& colour, cv::Mat* image) {
  constexpr double kCapital = 22, kSmallest = 12, kShare = 30;  // of the font at scale one [px]
  const double height = std::max(kSmallest, image->rows / kShare);
  const int width = std::max(1, static_cast<int>(std::lround(height / kSmallest)));
  const int left = static_cast<int>(std::lround(height / 2));
  const cv::Point corner(left, left + static_cast<int>(std::lround(height)));
  const auto draw = [&](const cv::Scalar& with, int thickness) {
    cv::putText(*image, text, corner, cv::FONT_HERSHEY_SIMPLEX, height / kCapital, with, thickness,
                cv::LINE_AA);
  };
  draw({0, 0, 0}, 3 * width);
  draw(colour, width);
}

}  // namespace palpate
