// Draws the slave's detections into an image.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/closed_curve.h"
#include "slave/vision/observation.h"

namespace palpate {

struct CameraOverlay {
  Curve edge_I;            // rest outline, moved as observed [px]; may be empty
  cv::Rect search_window;  // of the tip [px]
  TipObservation tip;
  std::optional<Eigen::Vector3d> force;  // object on tool, S [N]
  Eigen::Vector2d force_I{0, 0};         // the same as an arrow in the image [px]
  double sigma = 0;                      // one standard deviation of the force's magnitude [N]
  double sigma_I = 0;                    // the same along the arrow [px]
};

// The arrow for `force_S`: its direction in the image, and a length of a fifth of the image's
// `height` [px] at `full_scale` [N].
[[nodiscard]] Eigen::Vector2d ForceArrow(const CameraView& view, const Eigen::Vector3d& p_S,
                                         const Eigen::Vector3d& force_S, double full_scale,
                                         int height);

// A copy of `image` (grey or colour, 8 or 16 bit) as 8-bit colour with the overlay.
[[nodiscard]] cv::Mat Draw(const CameraOverlay& overlay, const cv::Mat& image);

}  // namespace palpate
