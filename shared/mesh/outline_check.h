// Whether an outline bounds a body at all.
#pragma once

#include "shared/mesh/outline.h"

namespace palpate {

// Throws std::invalid_argument saying what is wrong where: a loop of fewer than three points, a
// coordinate that is not finite, repeated points, no area (below 1e-12 of the bounding square),
// edges that cross, touch or fold back, a hole outside the outer loop or inside another hole. The
// loops may run either way. O(points^2).
void CheckOutline(const Outline& outline);

}  // namespace palpate
