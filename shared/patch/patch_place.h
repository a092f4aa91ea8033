// Nearest point on the surface of a patch.
#pragma once

#include <Eigen/Core>

#include "shared/state/surface_patch.h"

namespace palpate {

struct PatchPlace {
  int cell = -1;                     // -1: no surface, or the plane of one vertex
  Eigen::Vector3d weights{1, 0, 0};  // of the cell's vertices, sum 1
  Eigen::Vector3d p{0, 0, 0};        // the nearest point [m]
  Eigen::Vector3d normal{0, 1, 0};   // outward unit normal of its cell [-]
  double height = 0;                 // height of the point above it [m]; negative: below
  bool at_rim = false;               // the point is at the edge of the patch
};

// The point of `patch` nearest to `p` [m]. Among equally near cells, which share a vertex or an
// edge, the one with the largest |height| determines the side. O(cells), real-time safe.
PatchPlace NearestPlace(const SurfacePatch& patch, const Eigen::Vector3d& p) noexcept;

// Computes `rim` from vertices and cells.
void MarkRim(SurfacePatch* patch) noexcept;

// Index of a vertex of a cell, or the single vertex of a plane.
inline int VertexOf(const SurfacePatch& patch, int cell, int corner) noexcept {
  return cell < 0 ? 0
                  : patch.cells[static_cast<std::size_t>(cell)][static_cast<std::size_t>(corner)];
}

}  // namespace palpate
