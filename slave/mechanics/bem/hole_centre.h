// The place in a hole that lies farthest from the body.
#pragma once

#include <Eigen/Core>

#include "shared/mesh/outline.h"

namespace palpate {

struct HoleCentre {
  Eigen::Vector2d p_O{0, 0};  // [m]
  double radius = 0;          // of a circle around it that stays in the hole [m]
};

// The largest of the circles in the hole that touch the boundary in the middle of an element of
// `loop`. Slits have one as well as discs. O(n^2), n elements on the loop.
HoleCentre FindHoleCentre(const BoundaryMesh& mesh, int loop);

}  // namespace palpate
