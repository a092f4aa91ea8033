// Paper B's equation 6 and its choice of a triangle as printed, beside what the product does.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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

// The paper's choice of the triangle: the three nodes nearest to `p_O`. They need not form a
// triangle of the surface. O(N log N). Throws std::invalid_argument: fewer than three.
inline std::array<int, 3> NearestNodes(const SurfaceMesh& surface, const Eigen::Vector3d& p_O) {
  std::vector<int> nodes;
  for (const auto& triangle : surface.triangles) {
    nodes.insert(nodes.end(), triangle.begin(), triangle.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  if (nodes.size() < 3) {
    throw std::invalid_argument("a surface of " + std::to_string(nodes.size()) +
                                " nodes: accepted are three or more");
  }
  const auto distance = [&](int node) {
    return (surface.nodes.at(static_cast<std::size_t>(node)) - p_O).squaredNorm();
  };
  std::partial_sort(nodes.begin(), nodes.begin() + 3, nodes.end(), [&](int a, int b) {
    return std::pair(distance(a), a) < std::pair(distance(b), b);
  });
  return {nodes[0], nodes[1], nodes[2]};
}

}  // namespace palpate
