// Viewpoint and scales of a drawing.
#pragma once

#include <span>
#include <string>

#include <Eigen/Core>

namespace palpate {

// A parallel projection of frame S [m] into pixels, y down.
class Viewpoint {
 public:
  // From above and slightly from the side, z up, with `along` across the view. A vector that is
  // nearly vertical, zero or not finite counts as x.
  static Viewpoint Across(const Eigen::Vector3d& along);
  // x to the right, y up, for planar scenes.
  static Viewpoint Front();

  // Scales and shifts so that `points` fill the rectangle [px] and are centred in it.
  void Fit(std::span<const Eigen::Vector3d> points, const Eigen::Vector2d& corner,
           const Eigen::Vector2d& size);

  [[nodiscard]] Eigen::Vector2d ToPicture(const Eigen::Vector3d& p_S) const {
    return origin_ + scale_ * Across2d(p_S);
  }
  // A direction without the origin, `length` pixels per unit.
  [[nodiscard]] Eigen::Vector2d Direction(const Eigen::Vector3d& v_S, double length) const {
    return length * Across2d(v_S);
  }
  // Larger values are nearer to the viewer.
  [[nodiscard]] double Nearness(const Eigen::Vector3d& v_S) const { return toward_.dot(v_S); }
  [[nodiscard]] double scale() const { return scale_; }  // [px/m]

 private:
  Viewpoint(const Eigen::Vector3d& right, const Eigen::Vector3d& up, const Eigen::Vector3d& toward)
      : right_(right), up_(up), toward_(toward) {}
  [[nodiscard]] Eigen::Vector2d Across2d(const Eigen::Vector3d& v) const {
    return {right_.dot(v), -up_.dot(v)};
  }

  Eigen::Vector3d right_, up_, toward_;  // orthonormal, S
  Eigen::Vector2d origin_{0, 0};         // [px]
  double scale_ = 1;                     // [px/m]
};

// Round end of a scale: the least 1, 2, 4, 6 or 8 times a power of ten that is at least `value` > 0
// and at least `floor` > 0.
double RoundedUp(double value, double floor);

// Colour of `share` of a scale, 0 (pale) to 1 (dark), under `light`, 0 (dark) to 1, as `#rrggbb`.
std::string ColourOf(double share, double light = 1);

// `value` with three significant digits: 0.412, 12.5, 1e+06.
std::string Readable(double value);

}  // namespace palpate
