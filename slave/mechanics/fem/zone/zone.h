// A neighbourhood of a contact: the tetrahedra around it, cut out of the mesh.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

struct Zone {
  std::vector<int> nodes;                   // of the mesh
  std::vector<int> tets;                    // of the mesh, rising
  std::vector<std::array<int, 4>> corners;  // of every tetrahedron, numbered as in `nodes`
  std::vector<double> moduli;               // of every tetrahedron, by the body's [-]

  [[nodiscard]] int size() const { return static_cast<int>(nodes.size()); }
};

// Finds zones of one mesh.
class ZoneFinder {
 public:
  // Keeps a reference.
  explicit ZoneFinder(const SolidMesh& mesh);

  // The tetrahedra whose centroid is nearer to `centre_O` than `radius` [m] and not nearer to one
  // of `others`, and those at the nodes `touched`. `nodes` begins with `touched`. Tetrahedra that
  // are `taken` belong to another zone; those of this one will be.
  [[nodiscard]] Zone Around(const Eigen::Vector3d& centre_O, double radius,
                            std::span<const Eigen::Vector3d> others, std::span<const int> touched,
                            std::vector<char>* taken) const;

 private:
  const SolidMesh& mesh_;
  std::vector<Eigen::Vector3d> centroids_;  // per tetrahedron
};

}  // namespace palpate
