// Finds elements of a boundary mesh and of a contact patch (rules: slave/solve/README.md).
// Frame O [m].
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/outline.h"

namespace palpate {

// Distance from `p` to the nearest point of the straight element [m].
double DistanceTo(const BoundaryElement& element, const Eigen::Vector2d& p) noexcept;

// The element nearest to `p`; among equally near ones, such as at a common end, the one with the
// largest index. Equal means within 1e-9 of the mesh's length unit, the precision of a text file
// with ten digits. -1: empty mesh or `p` not finite. O(N).
int FindElement(const BoundaryMesh& mesh, const Eigen::Vector2d& p) noexcept;

// The elements of a patch of `width` [m] around `place` (projected onto `element`): every element
// of the same loop whose midpoint lies within width / 2 along the boundary, both ends included with
// a relative slack of 1e-9. A width of 0, or one that reaches no midpoint, selects the one
// element there. The order is along the boundary. Empty: index out of range, position or width not
// finite, negative width.
std::vector<int> PatchElements(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& place,
                               double width);
// Finds the elements without allocation: fills `patch` and returns the number of elements, which
// may exceed its size.
int PatchElements(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& place, double width,
                  std::span<int> patch) noexcept;

}  // namespace palpate
