// The skin of one elastic body, checked and ready for boundary elements.
#pragma once

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

}  // namespace palpate
