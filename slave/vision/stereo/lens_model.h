// The distortion of a Lens and its derivatives, for what inverts or fits it.
#pragma once

#include <Eigen/Core>

#include "slave/vision/stereo/rig.h"

namespace palpate {

// OpenCV's model: with r^2 = x^2 + y^2, x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y
// + p2 (r^2 + 2 x^2), y' = y (...) + p1 (r^2 + 2 y^2) + 2 p2 x y; `ray` = (x, y) = (X/Z, Y/Z).
struct Distorted {
  Eigen::Vector2d ray{0, 0};
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();  // d ray' / d ray
};
Distorted Distort(const Lens& lens, const Eigen::Vector2d& ray) noexcept;

// Whether the radial part still rises from the axis out to `ray`: beyond, two rays share a pixel.
bool IsInvertibleOutTo(const Lens& lens, const Eigen::Vector2d& ray) noexcept;

// Project() with d p_I / d p_C. False: behind the camera or outside the invertible range.
bool ProjectWithJacobian(const Lens& lens, const Eigen::Vector3d& p_C, Eigen::Vector2d* p_I,
                         Eigen::Matrix<double, 2, 3>* jacobian) noexcept;

}  // namespace palpate
