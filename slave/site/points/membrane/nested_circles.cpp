#include "slave/site/points/membrane/nested_circles.h"

#include <algorithm>
#include <cmath>

namespace palpate::site {

using Eigen::Vector2d;

Vector2d NestedCircles::At(const Place& place) const noexcept {
  const double way = std::max(place.s - 1, 0.0);  // from the tool's edge to the rim
  const double r = std::min(place.s, 1.0) * tool + way * (radius - tool);
  return {(1 - way) * eccentricity + r * std::cos(place.angle), r * std::sin(place.angle)};
}

// On the circle `way` from the tool to the rim, |d + way e| = tool + way (radius - tool) with d
// from the tool's centre and e the eccentricity: a quadratic equation, one of whose roots is
// positive.
NestedCircles::Place NestedCircles::Of(const Vector2d& p) const noexcept {
  const Vector2d d(p.x() - eccentricity, p.y());
  const double distance = d.norm();
  if (distance <= tool) return {distance / tool, std::atan2(d.y(), d.x())};
  const double gap = radius - tool;
  const double A = gap * gap - eccentricity * eccentricity;
  const double half_B = d.x() * eccentricity - tool * gap;
  const double C = (distance - tool) * (distance + tool);
  const double way = (half_B + std::sqrt(half_B * half_B + A * C)) / A;
  return {1 + way, std::atan2(d.y(), d.x() + way * eccentricity)};
}

}  // namespace palpate::site
