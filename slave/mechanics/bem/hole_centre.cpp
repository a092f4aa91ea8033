#include "slave/mechanics/bem/hole_centre.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace palpate {

// A circle of radius r that touches the boundary at m with its centre along the unit normal n
// leaves out the point q if |q - m|^2 >= 2 r n . (q - m).
HoleCentre FindHoleCentre(const BoundaryMesh& mesh, int loop) {
  const auto first = mesh.elements.begin() + mesh.loop_begin[static_cast<std::size_t>(loop)];
  const auto last = mesh.elements.begin() + mesh.loop_begin[static_cast<std::size_t>(loop) + 1];
  HoleCentre best;
  for (auto touched = first; touched != last; ++touched) {
    const Eigen::Vector2d m = touched->midpoint();
    const Eigen::Vector2d n = touched->normal();
    double radius = std::numeric_limits<double>::infinity();
    for (auto other = first; other != last; ++other) {
      for (const Eigen::Vector2d& q : {other->a, other->midpoint()}) {
        const double ahead = n.dot(q - m);
        if (ahead > 0) radius = std::min(radius, 0.5 * (q - m).squaredNorm() / ahead);
      }
    }
    if (radius > best.radius && radius < std::numeric_limits<double>::infinity()) {
      best = {m + radius * n, radius};
    }
  }
  return best;
}

}  // namespace palpate
