// Surfaces of single and joined boxes.
#pragma once

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// A box's boundary with its corners only.
inline SurfaceMesh BoxSurface(const Eigen::Vector3d& low, const Eigen::Vector3d& size) {
  SurfaceMesh box = SurfaceOf(MeshBox(size, {1, 1, 1}));
  for (Eigen::Vector3d& p : box.nodes) p += low;
  return box;
}

inline SurfaceMesh Joined(SurfaceMesh both, const SurfaceMesh& other) {
  const int first = static_cast<int>(both.nodes.size());
  both.nodes.insert(both.nodes.end(), other.nodes.begin(), other.nodes.end());
  for (const auto& [a, b, c] : other.triangles) {
    both.triangles.push_back({a + first, b + first, c + first});
  }
  return both;
}

}  // namespace palpate
