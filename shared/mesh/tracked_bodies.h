// From the closed polygons of a tracker to the bodies that they bound: what is left to mesh when an
// outline has split, merged, or a hole has opened or closed. Frame of the polygons [m].
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"

namespace palpate {

// The bodies, largest area first, outer loops counter-clockwise, holes clockwise. Polygons run
// either way and come in any order; the last point may repeat the first. One that lies in no other,
// or in an even number of others, bounds a body; in an odd number, a hole of the innermost of
// those; a body may lie in the hole of another. Points that repeat the one before are dropped, and
// so are polygons whose area is `smallest_area` [m^2] or less, or which have no area at all: specks
// and threads that are left where an outline pinched off. Throws std::invalid_argument naming the
// polygons: a coordinate that is not finite, polygons that cross or touch themselves or each other,
// none left.
std::vector<Outline> BodiesOf(const std::vector<std::vector<Eigen::Vector2d>>& polygons,
                              double smallest_area = 0);

// The body that a tool at `tip` meets: the one that contains it, else the one whose boundary is
// nearest. Index in `bodies`; -1: none, or `tip` not finite.
int BodyUnder(std::span<const Outline> bodies, const Eigen::Vector2d& tip);

}  // namespace palpate
