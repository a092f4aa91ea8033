#include "slave/pipeline/camera/overlay.h"

#include <cmath>
#include <cstdio>

#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

const cv::Scalar kContourColour(80, 200, 80), kWindowColour(220, 160, 60), kTipColour(60, 60, 240),
    kForceColour(40, 140, 255);

cv::Point Round(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))};
}

cv::Mat ToColour(const cv::Mat& image) {
  cv::Mat eight, colour;
  image.convertTo(eight, CV_8U, image.depth() == CV_16U ? 1.0 / 257 : 1.0);
  if (eight.channels() == 3) return eight.clone();
  cv::cvtColor(eight, colour, cv::COLOR_GRAY2BGR);
  return colour;
}

}  // namespace

cv::Mat DrawOverlay(const cv::Mat& image, const Overlay& overlay) {
  cv::Mat picture = ToColour(image);
  std::vector<cv::Point> contour;
  contour.reserve(overlay.contour_I.size());
  for (const Eigen::Vector2d& p : overlay.contour_I) contour.push_back(Round(p));
  if (!contour.empty()) {
    cv::polylines(picture, contour, true, kContourColour, 1, cv::LINE_AA);
    for (const cv::Point& p : contour) cv::circle(picture, p, 2, kContourColour, -1, cv::LINE_AA);
  }
  cv::rectangle(picture, overlay.search_window, kWindowColour, 1);
  const cv::Point tip = Round(overlay.tip.p_I);
  if (overlay.tip.found)
    cv::drawMarker(picture, tip, kTipColour, cv::MARKER_CROSS, 13, 1, cv::LINE_AA);
  char text[64];
  if (overlay.force) {
    if (overlay.force_I.norm() > 1) {
      cv::arrowedLine(picture, tip, Round(overlay.tip.p_I + overlay.force_I), kForceColour, 2,
                      cv::LINE_AA, 0, 0.2);
    }
    std::snprintf(text, sizeof text, "%.3g N  score %.2f", overlay.force->norm(),
                  overlay.tip.score);
  } else {
    std::snprintf(text, sizeof text, "force unknown");
  }
  cv::putText(picture, text, {8, 20}, cv::FONT_HERSHEY_SIMPLEX, 0.5, kForceColour, 1, cv::LINE_AA);
  return picture;
}

Eigen::Vector2d ForceArrow(const CameraView& view, const Eigen::Vector3d& p_S,
                           const Eigen::Vector3d& force_S, double full_scale, int height) {
  const double magnitude = force_S.norm();
  if (!(magnitude > 0) || !(full_scale > 0)) return {0, 0};
  const Eigen::Vector3d ahead = p_S + force_S / magnitude * view.pixel();
  const Eigen::Vector2d direction = view.ToImage(ahead) - view.ToImage(p_S);
  return direction * (0.2 * height * std::fmin(1.5, magnitude / full_scale));
}

}  // namespace palpate
