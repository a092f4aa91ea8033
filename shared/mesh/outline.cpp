#include "shared/mesh/outline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate {

int BoundaryMesh::Next(int i) const {
  const auto end = std::ranges::upper_bound(loop_begin, i);
  return i + 1 < *end ? i + 1 : *(end - 1);
}

int BoundaryMesh::Previous(int i) const {
  const auto end = std::ranges::upper_bound(loop_begin, i);
  return i > *(end - 1) ? i - 1 : *end - 1;
}

double SignedArea(const std::vector<Eigen::Vector2d>& loop) {
  double twice = 0;  // relative to the first point: no cancellation far from the origin
  for (std::size_t i = 2; i < loop.size(); ++i) {
    const Eigen::Vector2d u = loop[i - 1] - loop[0];
    const Eigen::Vector2d v = loop[i] - loop[0];
    twice += u.x() * v.y() - u.y() * v.x();
  }
  return 0.5 * twice;
}

Eigen::Vector2d Centroid(const std::vector<Eigen::Vector2d>& loop) {
  double twice = 0;
  Eigen::Vector2d moment(0, 0);  // six times the first moment about the first point
  for (std::size_t i = 2; i < loop.size(); ++i) {
    const Eigen::Vector2d u = loop[i - 1] - loop[0];
    const Eigen::Vector2d v = loop[i] - loop[0];
    const double cross = u.x() * v.y() - u.y() * v.x();
    twice += cross;
    moment += cross * (u + v);
  }
  return loop[0] + moment / (3 * twice);
}

namespace {

// Even-odd rule: how often a ray towards +x leaves or enters.
bool IsInside(const std::vector<Eigen::Vector2d>& loop, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
    const Eigen::Vector2d& a = loop[i];
    const Eigen::Vector2d& b = loop[j];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y())) inside = !inside;
  }
  return inside;
}

}  // namespace

bool Contains(const Outline& outline, const Eigen::Vector2d& p) {
  return IsInside(outline.outer, p) &&
         std::ranges::none_of(outline.holes, [&](const auto& hole) { return IsInside(hole, p); });
}

}  // namespace palpate
