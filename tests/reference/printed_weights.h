// Paper B's equation 6 as printed, beside what the product does.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/contact/surface_contact.h"

namespace palpate {

// Equation 6 at `p` for the triangle a, b, c: weights of its nodes. `kUnsigned` are the
// sub-triangle areas as the paper prints them, which make force from nothing outside the triangle;
// `kSigned` are exact in force and moment, and negative outside; `kClosest` are those of the
// triangle's closest point, exact in force, and in moment about that point. A triangle without area
// has no areas: signed and unsigned weights are zero there.
enum class AreaWeights : std::uint8_t { kClosest, kSigned, kUnsigned };
inline Eigen::Vector3d TriangleWeights(const Eigen::Vector3d& p,
                                       const std::array<Eigen::Vector3d, 3>& abc,
                                       AreaWeights kind) {
  if (kind == AreaWeights::kClosest) return ClosestOnTriangle(p, abc, {true, true, true}).weights;
  const Eigen::Vector3d normal = AreaNormal(abc);
  if (normal == Eigen::Vector3d(0, 0, 0)) return {0, 0, 0};
  const Eigen::Vector3d a = abc[0] - p, b = abc[1] - p, c = abc[2] - p;
  if (kind == AreaWeights::kUnsigned) {
    return Eigen::Vector3d(b.cross(c).norm(), c.cross(a).norm(), a.cross(b).norm()) / normal.norm();
  }
  return Eigen::Vector3d(normal.dot(b.cross(c)), normal.dot(c.cross(a)), normal.dot(a.cross(b))) /
         normal.squaredNorm();
}

}  // namespace palpate
