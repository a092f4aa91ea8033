#include "slave/pipeline/camera/camera_overlay.h"

#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/pipeline/base/overlay_text.h"

namespace palpate {
namespace {

const cv::Scalar kEdgeColour(80, 200, 80), kWindowColour(220, 160, 60), kTipColour(60, 60, 240),
    kForceColour(40, 140, 255);

cv::Point NearestPixel(const Eigen::Vector2d& p) {
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

Eigen::Vector2d ForceArrow(const CameraView& view, const Eigen::Vector3d& p_S,
                           const Eigen::Vector3d& force_S, double full_scale, int height) {
  const double magnitude = force_S.norm();
  if (!(magnitude > 0) || !(full_scale > 0)) return {0, 0};
  const Eigen::Vector3d ahead = p_S + force_S / magnitude * view.pixel();
  const Eigen::Vector2d direction = view.ToImage(ahead) - view.ToImage(p_S);
  return direction * (0.2 * height * std::fmin(1.5, magnitude / full_scale));
}

cv::Mat Draw(const CameraOverlay& overlay, const cv::Mat& image) {
  cv::Mat drawn = ToColour(image);
  std::vector<cv::Point> edge;
  for (const Eigen::Vector2d& p : overlay.edge_I) edge.push_back(NearestPixel(p));
  OnAnyImage(kEdgeColour, 1, [&](const cv::Scalar& colour, int thickness) {
    if (!edge.empty()) cv::polylines(drawn, edge, true, colour, thickness, cv::LINE_AA);
  });
  OnAnyImage(kWindowColour, 1, [&](const cv::Scalar& colour, int thickness) {
    cv::rectangle(drawn, overlay.search_window, colour, thickness);
  });
  OnAnyImage(kTipColour, 1, [&](const cv::Scalar& colour, int thickness) {
    if (!overlay.tip.found) return;
    cv::drawMarker(drawn, NearestPixel(overlay.tip.p_I), colour, cv::MARKER_CROSS, 13, thickness,
                   cv::LINE_AA);
  });
  if (!overlay.force) {
    DrawText("force unknown", kForceColour, &drawn);
    return drawn;
  }
  const Eigen::Vector2d end = overlay.tip.p_I + overlay.force_I;
  DrawArrow({overlay.tip.p_I.x(), overlay.tip.p_I.y()}, {end.x(), end.y()}, overlay.sigma_I,
            kForceColour, &drawn);
  DrawText(fmt::format("{:.3g} N +- {:.2g}  score {:.2f}", overlay.force->norm(), overlay.sigma,
                       overlay.tip.score),
           kForceColour, &drawn);
  return drawn;
}

}  // namespace palpate
