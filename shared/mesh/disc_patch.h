// Finds points of a triangulated surface, and nodes or triangles of a contact patch (rules:
// slave/solve/README.md). Frame O [m].
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// A point on or near the surface.
struct SurfacePlace {
  int node = -1;      // a node at the point, also an inner one; -1: none
  int triangle = -1;  // the nearest triangle; among equally near ones the largest index
  // Barycentric, of the nearest point of that triangle, each >= 0.
  Eigen::Vector3d weights{0, 0, 0};
  double distance = 0;  // to that point, or to the node if there is one [m]
};

// A node within 1e-6 of the bounding box's diagonal matches. nullopt: `p_O` is not finite, or
// farther from the surface than half the longest edge of the nearest triangle (and no node there).
// O(N).
std::optional<SurfacePlace> FindPlace(const SurfaceMesh& surface, const Eigen::Vector3d& p_O);

// Outward unit normal of a triangle; zero if it has no area.
Eigen::Vector3d Normal(const SurfaceMesh& surface, int triangle);
double Area(const SurfaceMesh& surface, int triangle);
Eigen::Vector3d Centroid(const SurfaceMesh& surface, int triangle);

// The triangles around each node of a surface.
class NodeTriangles {
 public:
  explicit NodeTriangles(const SurfaceMesh& surface);
  [[nodiscard]] std::span<const int> Of(int node) const {
    const auto i = static_cast<std::size_t>(node);
    return std::span(triangles_)
        .subspan(static_cast<std::size_t>(first_[i]),
                 static_cast<std::size_t>(first_[i + 1] - first_[i]));
  }

 private:
  std::vector<int> first_, triangles_;
};

// The part of a disc on a surface, without the part beyond its edges.
struct DiscShare {
  double area = 0;                 // [m^2]
  double rim = 0;                  // angle of the circle's arcs [rad], 2 pi: all of it
  Eigen::Vector3d first{0, 0, 0};  // integral of the position relative to the disc's centre [m^3]
};
// Part of the sphere of `radius` [m] around p_O on one triangle: a circle in its plane.
DiscShare DiscOnTriangle(const SurfaceMesh& surface, int triangle, const Eigen::Vector3d& p_O,
                         double radius);

// The patch of a disc of diameter `width` > 0 around `place` at `p_O`: triangles whose centroid,
// nodes that lie within width / 2 of it (1e-9 relative slack) on triangles that face the same way
// (within 60 degrees of the mean normal at the place) and are connected with the place through such
// triangles that the disc meets: a thin object is touched on one side only, and parts beyond a gap
// or a step are not touched. If no centroid is that near, `triangles` has the triangle at the
// point, `nodes` is empty and the weights of the point apply. Indices are in rising order.
struct DiscPatch {
  std::vector<int> triangles;  // carry a uniform load, a third of each per node
  std::vector<int> nodes;      // have the same displacement
  // On all these triangles [m^2].
  DiscShare disc;
  double node_area = 0;      // a third of each triangle per node of the patch
  double triangle_area = 0;  // area of the triangles of the patch
};
DiscPatch PatchAt(const SurfaceMesh& surface, const SurfacePlace& place, const Eigen::Vector3d& p_O,
                  double width);

}  // namespace palpate
