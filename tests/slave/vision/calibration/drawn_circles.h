// Images of circle grids, drawn ray by ray.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "slave/vision/calibration/board.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// Draws dark discs on a bright plane as seen by a camera without distortion, with 4 x 4 rays per
// pixel.
inline cv::Mat DrawCircles(const Board& board, double radius, const Lens& lens,
                           const Eigen::Isometry3d& X_CB) {
  constexpr int kFine = 4;
  const Eigen::Isometry3d X_BC = X_CB.inverse();
  const std::vector<cv::Point3f> centres = BoardPoints(board);
  cv::Mat image(lens.size[1], lens.size[0], CV_8U);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      int dark = 0;
      for (int k = 0; k < kFine * kFine; ++k) {
        const Eigen::Vector2d p_I(u + (k % kFine + 0.5) / kFine - 0.5,
                                  v + (k / kFine + 0.5) / kFine - 0.5);
        const Eigen::Vector3d ray =
            X_BC.linear() *
            Eigen::Vector3d((p_I.x() - lens.cx) / lens.fx, (p_I.y() - lens.cy) / lens.fy, 1);
        const Eigen::Vector3d eye = X_BC.translation();
        const Eigen::Vector3d at = eye - eye.z() / ray.z() * ray;
        dark += std::any_of(centres.begin(), centres.end(), [&](const cv::Point3f& c) {
          return std::hypot(at.x() - c.x, at.y() - c.y) < radius;
        });
      }
      image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(220 - 190 * dark / (kFine * kFine));
    }
  }
  return image;
}

}  // namespace palpate
