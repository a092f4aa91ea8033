#include "slave/tactile/localise/contact_point.h"

#include <cassert>
#include <cstddef>

namespace palpate {

std::optional<ContactPoint> ContactPointOf(std::span<const Eigen::Vector3d> p,
                                           std::span<const double> intensity,
                                           Division division) noexcept {
  assert(p.size() == intensity.size());
  ContactPoint point;
  double total = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    point.centroid += p[i];
    total += intensity[i];
  }
  if (!(total > 0)) return std::nullopt;
  const auto m = static_cast<double>(p.size());
  point.centroid /= m;
  Eigen::Vector3d d(0, 0, 0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    d += intensity[i] / total * (p[i] - point.centroid);
  }
  point.c = point.centroid + (division == Division::kTwice ? Eigen::Vector3d(d / m) : d);
  if (!point.c.allFinite()) return std::nullopt;
  return point;
}

}  // namespace palpate
