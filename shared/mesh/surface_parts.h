// The parts of a closed surface and which of them lie inside others.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// Triangles connected by edges. Parts that share only a node are separate.
struct SurfacePart {
  std::vector<int> triangles;
  int depth = 0;  // number of other parts around it; odd: it bounds a cavity
};
// Parts of a surface without open edges. Empty: more than kMostParts. O(parts x triangles).
constexpr std::size_t kMostParts = 1000;
std::vector<SurfacePart> ClosedParts(const SurfaceMesh& surface);

// Winding number of the triangles around `p` (unsigned; sum of their solid angles over 4 pi): 1
// inside a simple closed part, 0 outside. Source: van Oosterom and Strackee, IEEE Trans. Biomed.
// Eng. 30 (1983) 125-126, eq. 8.
double WindingNumber(const SurfaceMesh& surface, const std::vector<int>& triangles,
                     const Eigen::Vector3d& p);

// Volume enclosed by triangles that point outward [m^3].
double EnclosedVolume(const SurfaceMesh& surface, const std::vector<int>& triangles);

}  // namespace palpate
