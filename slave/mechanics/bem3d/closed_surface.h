// The skin of one elastic body, checked and ready for boundary elements, and what moves its
// corners.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/bem3d/kelvin_triangle.h"

namespace palpate {

struct ClosedSurface {
  double length_unit = 0;              // the bounding box's largest side [m]
  Eigen::Vector3d origin_O{0, 0, 0};   // the bounding box's centre [m]
  std::vector<FlatTriangle> elements;  // (p_O - origin_O) / length_unit
  bool has_cavities = false;

  // Throws std::invalid_argument with the number of the triangle: nodes that do not exist or are
  // not finite, no area (below 1e-10 of the longest edge squared), the same triangle twice, an edge
  // without exactly one neighbour, neighbours of opposite orientation, a skin inside out, more than
  // one body, a cavity outside of the body. O(N log N + N times the cavities).
  explicit ClosedSurface(const SurfaceMesh& mesh);

  [[nodiscard]] int size() const { return static_cast<int>(elements.size()); }
};

// Displacements at the corners of triangles from those at the centroids: what makes the
// displacement linear on every triangle without a single unknown more.
//
// At each node the displacements of the triangles around it are fitted by a function that is linear
// in space (least squares), and the fit's value at the node is taken. So a displacement that is
// linear in space is met exactly, a rigid turn among them. Displacements that are constant on each
// triangle miss it by O(h), and the deformation by O(h G / K): uniform tension by 1.3 % at nu = 0.3
// but by 66 % at nu = -0.9, on a cube of 432 triangles.
class CornerFit {
 public:
  struct Share {
    int triangle = 0;
    double weight = 0;
  };
  // The displacement of a node is the weighted sum of those of some triangles.
  using Shares = std::vector<Share>;

  // The triangles at a node; if they do not determine its position (a box's corner) also those
  // around them. A direction in which they hardly extend is not extrapolated along. O(N).
  CornerFit(const SurfaceMesh& mesh, const ClosedSurface& surface);

  [[nodiscard]] int nodes() const { return static_cast<int>(shares_.size()); }
  [[nodiscard]] const Shares& shares(int node) const {
    return shares_[static_cast<std::size_t>(node)];
  }
  // Of each triangle, counted from zero, those only that a triangle has.
  [[nodiscard]] const std::array<int, 3>& corners(int triangle) const {
    return corners_[static_cast<std::size_t>(triangle)];
  }

 private:
  void NumberCorners(const SurfaceMesh& mesh);

  std::vector<std::array<int, 3>> corners_;
  std::vector<Shares> shares_;
};

}  // namespace palpate
