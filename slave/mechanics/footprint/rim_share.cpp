#include "slave/mechanics/footprint/rim_share.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

double Square(double x) {
  return x * x;
}

// Share of the length 2 `part` around `x` that lies within `half` of zero.
double ShareOfLength(double half, double part, double x) {
  const double from = std::max(x - part, -half), to = std::min(x + part, half);
  return std::max(0.0, to - from) / (2 * part);
}

}  // namespace

double PartRadius(double area) noexcept {
  return std::sqrt(area / std::numbers::pi);
}

double ShareUnderDisc(double radius, double part_radius, double distance) noexcept {
  if (distance >= radius + part_radius) return 0;
  if (distance <= radius - part_radius) return 1;
  if (distance <= part_radius - radius) return Square(radius / part_radius);
  // The area of the lens that two circles have in common.
  const double R = radius, r = part_radius, d = distance;
  const double angle_r =
      std::acos(std::clamp((Square(d) + Square(r) - Square(R)) / (2 * d * r), -1.0, 1.0));
  const double angle_R =
      std::acos(std::clamp((Square(d) + Square(R) - Square(r)) / (2 * d * R), -1.0, 1.0));
  const double kite =
      0.5 * std::sqrt(std::max(0.0, (R + r - d) * (d + r - R) * (d + R - r) * (d + R + r)));
  const double area = Square(r) * angle_r + Square(R) * angle_R - kite;
  return std::clamp(area / (std::numbers::pi * Square(r)), 0.0, 1.0);
}

double ShareUnderRectangle(double along, double across, double part_radius, double x,
                           double y) noexcept {
  // Half the side of the square with the part's area.
  const double part = 0.5 * std::sqrt(std::numbers::pi) * part_radius;
  return ShareOfLength(along, part, x) * ShareOfLength(across, part, y);
}

DiscCompliance SpringAtRim(double poisson_ratio, double part_radius, double share) noexcept {
  const DiscCompliance even = OfEvenLoad(poisson_ratio);
  const double factor = (1 / share - 1) / part_radius;
  return {factor * even.normal, factor * even.across};
}

}  // namespace palpate
