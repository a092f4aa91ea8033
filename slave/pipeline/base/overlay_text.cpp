#include "slave/pipeline/base/overlay_text.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace palpate {

void DrawText(const std::string& text, const cv::Scalar& colour, cv::Mat* image) {
  constexpr double kCapital = 22, kMinHeight = 12, kShare = 30;  // of the font at scale one [px]
  const double height = std::max(kMinHeight, image->rows / kShare);
  const int width = std::max(1, static_cast<int>(std::lround(height / kMinHeight)));
  const int left = static_cast<int>(std::lround(height / 2));
  const cv::Point corner(left, left + static_cast<int>(std::lround(height)));
  const auto draw = [&](const cv::Scalar& with, int thickness) {
    cv::putText(*image, text, corner, cv::FONT_HERSHEY_SIMPLEX, height / kCapital, with, thickness,
                cv::LINE_AA);
  };
  draw({0, 0, 0}, 3 * width);
  draw(colour, width);
}

void DrawArrow(const cv::Point2d& from, const cv::Point2d& to, double sigma,
               const cv::Scalar& colour, cv::Mat* image) {
  constexpr int kThickness = 2;  // [px]
  // Head relative to the arrow's length; half length of a mark across it [px].
  constexpr double kHead = 0.2, kHalfBar = 5.5;
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  if (!(length > 1)) return;
  const cv::Point2d along = (to - from) / length, across(-along.y, along.x);
  OnAnyImage(colour, kThickness, [&](const cv::Scalar& with, int thickness) {
    cv::arrowedLine(*image, from, to, with, thickness, cv::LINE_AA, 0, kHead);
    if (!(sigma > 0.5)) return;
    for (const double end : {std::fmax(0.0, length - sigma), length + sigma}) {
      const cv::Point2d middle = from + end * along;
      cv::line(*image, middle - kHalfBar * across, middle + kHalfBar * across, with, thickness,
               cv::LINE_AA);
    }
    cv::line(*image, to, from + (length + sigma) * along, with, 1, cv::LINE_AA);
  });
}

}  // namespace palpate
