// Places on a boundary mesh and the elements of a contact patch there (contracts, `solve`: the
// rules for places and `width`). Frame O [m].
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"

namespace palpate {

// Distance from `p` to the nearest point of the straight element [m].
double DistanceTo(const BoundaryElement& element, const Eigen::Vector2d& p) noexcept;

// The element nearest to `p`; among equally near ones, which a place between two elements is, that
// with the largest index. Equal means within 1e-9 of the mesh's length unit: what is left of a
// coordinate that went through a text file of ten digits. -1: empty mesh or `p` not finite. O(N).
int FindElement(const BoundaryMesh& mesh, const Eigen::Vector2d& p) noexcept;

// The elements of a patch of `width` [m] around `place` (projected onto `element`): every element
// of the same loop whose midpoint lies within width / 2 along the boundary, both ends included with
// a relative slack of 1e-9. A width of 0, or one too narrow to reach any midpoint, is the one
// element there. In order along the boundary, none twice. Empty: index out of range, place or width
// not finite, negative width.
std::vector<int> PatchElements(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& place,
                               double width);
// The same without allocation: fills `patch` as far as it reaches and returns how many elements the
// patch has, which may be more than fit.
int PatchElements(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& place, double width,
                  std::span<int> patch) noexcept;

}  // namespace palpate
