// A fingertip's contact meets the object's mesh (paper B, III.B, equations 5 to 7).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// Where a point meets a surface. Frame O.
struct TouchedPlace {
  int triangle = -1;
  Eigen::Vector3d p_O{0, 0, 0};      // closest point of the surface at rest [m]
  Eigen::Vector3d n_O{0, 0, 0};      // outward unit normal of its triangle
  Eigen::Vector3d weights{0, 0, 0};  // of the triangle's three nodes, each 0 to 1, sum 1
  double distance = 0;               // [m], >= 0
  bool inside = false;               // the point lies behind the surface, not on it
};

// Finds the closest place of a closed surface. Keeps its own search tree; const members are
// thread-safe and allocation-free. Of triangles that share the closest edge or node, the place is
// on the one that the point lies farthest in front of or behind.
class SurfaceContact {
 public:
  // O(N log N). Triangles without area are passed over. Throws std::invalid_argument: no triangle
  // has one, a node is missing or not finite.
  explicit SurfaceContact(SurfaceMesh surface);
  ~SurfaceContact();

  // nullopt: farther than `gate` [m] from the surface (paper B: 1 cm), or not finite.
  [[nodiscard]] std::optional<TouchedPlace> Find(const Eigen::Vector3d& p_O,
                                                 double gate) const noexcept;
  [[nodiscard]] const SurfaceMesh& surface() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

// Equation 6 at `p` for the triangle a, b, c: weights of its nodes. `kUnsigned` are the
// sub-triangle areas as the paper prints them, which make force from nothing outside the triangle;
// `kSigned` are exact in force and moment, and negative outside; `kClosest` are those of the
// triangle's closest point, exact in force, and in moment about that point. A triangle without area
// has no areas: signed and unsigned weights are zero there.
enum class AreaWeights : std::uint8_t { kClosest, kSigned, kUnsigned };
Eigen::Vector3d TriangleWeights(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& abc,
                                AreaWeights kind) noexcept;

// The paper's choice of the triangle: the three nodes nearest to `p_O`. They need not form a
// triangle of the surface. O(N log N). Throws std::invalid_argument: fewer than three.
std::array<int, 3> NearestNodes(const SurfaceMesh& surface, const Eigen::Vector3d& p_O);

}  // namespace palpate
