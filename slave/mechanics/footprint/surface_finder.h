// Places and patches of contacts on a triangulated surface (contracts, `solve`), found quickly.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/mesh/surface_patch.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

// What FindPlace and PatchAt tell, from tables: O(1) where the contact names its triangle and has
// no width, no allocation once patches of that size were seen.
class SurfaceFinder {
 public:
  explicit SurfaceFinder(SurfaceMesh surface);

  // The contact's triangle, or the nearest one; nullopt: farther than half its longest edge.
  [[nodiscard]] std::optional<SurfacePlace> Find(const Contact& contact) const;
  // Mean of the normals of the triangles there, unit; zero where they cancel.
  [[nodiscard]] Eigen::Vector3d NormalAt(const SurfacePlace& place) const;
  // As PatchAt; valid until the next call. Nodes in rising order, triangles too. O(N).
  void FindPatch(const SurfacePlace& place, const Eigen::Vector3d& p_O, double width);
  [[nodiscard]] const SurfacePatch& patch() const { return patch_; }

  [[nodiscard]] const SurfaceMesh& surface() const { return surface_; }
  [[nodiscard]] double area(int triangle) const {
    return areas_[static_cast<std::size_t>(triangle)];
  }

 private:
  void AddTriangle(int triangle);
  [[nodiscard]] std::optional<SurfacePlace> OnTriangle(int triangle,
                                                       const Eigen::Vector3d& p_O) const;
  [[nodiscard]] std::span<const int> TrianglesOf(int node) const;

  SurfaceMesh surface_;
  double diagonal_ = 0;  // [m]
  std::vector<Eigen::Vector3d> normals_, centroids_;
  std::vector<double> areas_;
  std::vector<int> first_of_node_, triangles_of_node_;
  SurfacePatch patch_;
  std::vector<int> seen_;  // per node: the last patch that it is in
  int patches_ = 0;
};

}  // namespace palpate
