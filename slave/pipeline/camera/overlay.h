// What the slave sees, drawn into its picture for a person.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/observation.h"

namespace palpate {

struct Overlay {
  std::vector<Eigen::Vector2d> contour_I;  // [px]
  cv::Rect search_window;                  // [px]
  TipObservation tip;
  std::optional<Eigen::Vector3d> force;  // object on tool, S [N]
  Eigen::Vector2d force_I{0, 0};         // the same as an arrow in the picture [px]
};

// A copy of `image` (grey or colour, 8 or 16 bit) as 8-bit colour with contour, search window, tip,
// force arrow and the force in numbers.
cv::Mat DrawOverlay(const cv::Mat& image, const Overlay& overlay);

// The arrow for `force_S` in the picture: the direction seen, and a length of a fifth of the
// picture's height at `full_scale` [N].
Eigen::Vector2d ForceArrow(const CameraView& view, const Eigen::Vector3d& p_S,
                           const Eigen::Vector3d& force_S, double full_scale, int height);

}  // namespace palpate
