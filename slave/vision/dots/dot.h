// A dot in one image, and its measurement from a region of pixels.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace palpate {

// Dark dots on a light ground, or light ones on a dark ground.
enum class DotTone : std::uint8_t { kDark, kLight };

// Pixels: (0, 0) is the centre of the upper left one.
struct Dot {
  Eigen::Vector2d centre{0, 0};                     // grey-weighted centroid [px]
  Eigen::Matrix2d shape = Eigen::Matrix2d::Zero();  // second moments; a disc has r^2 / 4 I [px^2]
  double area = 0;                                  // [px^2]
  double sigma = 0;  // of the centroid, per axis, from the noise around the dot [px]
};

struct DotShapeLimits {
  double area_min = 30, area_max = 20000;  // [px^2]
  double axes_ratio_min = 0.3;             // short to long axis
  double contrast_min = 20;                // [levels]
};

// Fits a dot to a region of pixels: an ellipse by the second moments of the pixels, its area is 4
// pi sqrt(det) of these. `origin`: of the pixels in the image. nullopt: outside `limits`, or not
// elliptical.
std::optional<Dot> EllipseOf(const cv::Moments& region, const cv::Point& origin,
                             const DotShapeLimits& limits) noexcept;

// The grey-weighted centroid. The background is a plane fitted to a ring around the dot, so that a
// gradient of light does not shift the result; parts of the ring with another edge are excluded.
// The weight of a pixel is its difference from the background, within 2 px of the dot's edge or as
// far as its blur reaches; less far towards another edge and opposite to it. `dot` is the result of
// EllipseOf. nullopt: too little contrast, half the ring is not background, no image around it, an
// edge that deviates from the ellipse by a pixel or more.
std::optional<Dot> RefineDot(const cv::Mat& image, const Dot& dot, int threshold, DotTone tone,
                             const DotShapeLimits& limits) noexcept;

}  // namespace palpate
