// Where a point is by the surface of a patch.
#pragma once

#include <Eigen/Core>

#include "shared/state/surface_patch.h"

namespace palpate {

struct PatchPlace {
  int cell = -1;                     // -1: there is no surface, or the plane of one vertex
  Eigen::Vector3d weights{1, 0, 0};  // of the cell's vertices, sum 1
  Eigen::Vector3d p{0, 0, 0};        // the nearest place [m]
  Eigen::Vector3d normal{0, 1, 0};   // outward unit normal of its cell [-]
  double height = 0;                 // of the point over it [m]; negative: behind
  bool at_rim = false;               // the surface ends there: the patch knows no more
};

// The nearest place of `patch` to `p` [m]. Of equally near cells, which share a vertex or an edge,
// that which `p` lies farther in front of or behind tells the side. O(cells), real-time safe.
PatchPlace NearestPlace(const SurfacePatch& patch, const Eigen::Vector3d& p) noexcept;

// Fills `rim` of a patch whose vertices and cells are set.
void MarkRim(SurfacePatch* patch) noexcept;

// Numbers of the vertices of a cell; of the plane its one vertex.
inline int VertexOf(const SurfacePatch& patch, int cell, int corner) noexcept {
  return cell < 0 ? 0
                  : patch.cells[static_cast<std::size_t>(cell)][static_cast<std::size_t>(corner)];
}

}  // namespace palpate
