// Whether an outline bounds a body at all.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"

namespace palpate {

// Throws std::invalid_argument saying what is wrong where: a loop of fewer than three points, a
// coordinate that is not finite, repeated points, no area (below 1e-12 of the bounding square),
// edges that cross, touch or fold back, a hole outside the outer loop or inside another hole. The
// loops may run either way. O(points^2).
void CheckOutline(const Outline& outline);
// Two closed polygons of three points or more share a point of their boundaries. O(points^2).
bool LoopsMeet(const std::vector<Eigen::Vector2d>& one, const std::vector<Eigen::Vector2d>& other);

}  // namespace palpate
