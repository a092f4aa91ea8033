// Where a picture is seen from, and its scales.
#pragma once

#include <span>
#include <string>

#include <Eigen/Core>

namespace palpate {

// A parallel projection of frame S [m] into pixels, y down.
class Viewpoint {
 public:
  // From above and a little aside, z up, turned so that what happens along `along` is seen from the
  // side. Nearly upright, zero or not finite: as if along x.
  static Viewpoint Across(const Eigen::Vector3d& along);
  // x to the right, y up: planar scenes.
  static Viewpoint Front();

  // Scales and shifts so that `points` fill the rectangle [px] and are centred in it.
  void Fit(std::span<const Eigen::Vector3d> points, const Eigen::Vector2d& corner,
           const Eigen::Vector2d& size);

  [[nodiscard]] Eigen::Vector2d ToPicture(const Eigen::Vector3d& p_S) const {
    return origin_ + scale_ * Across2d(p_S);
  }
  // A direction: without the origin, at `length` pixels per unit.
  [[nodiscard]] Eigen::Vector2d Direction(const Eigen::Vector3d& v_S, double length) const {
    return length * Across2d(v_S);
  }
  // Larger is nearer to the viewer.
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

// A scale's round end, which does not flicker: the least 1, 2, 4, 6 or 8 times a power of ten that
// is not below `value` > 0; `floor` > 0 for less.
double RoundedUp(double value, double floor);

// Colour of `share` of a scale, 0 (pale) to 1 (dark), under `light`, 0 (dark) to 1, as `#rrggbb`.
std::string ColourOf(double share, double light = 1);

// `value` with so many significant digits as a person reads: 0.412, 12.5, 1e+06.
std::string Readable(double value);

}  // namespace palpate
