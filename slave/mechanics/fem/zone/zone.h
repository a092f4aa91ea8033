// A neighbourhood of a contact: the tetrahedra around it, cut out of the mesh.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

struct Zone {
  std::vector<int> nodes;  // of the mesh: the inner ones first, then those that the rest shares
  int inner = 0;           // how many nodes belong to the zone alone
  std::vector<int> tets;   // of the mesh, rising
  std::vector<std::array<int, 4>> corners;  // of every tetrahedron, numbered as in `nodes`

  [[nodiscard]] int size() const { return static_cast<int>(nodes.size()); }
  [[nodiscard]] int border() const { return size() - inner; }
  // Number of a node of the mesh; -1: it is not in the zone. O(size).
  [[nodiscard]] int Find(int node) const;
};

// Finds zones of one mesh.
class ZoneFinder {
 public:
  // Keeps a reference.
  explicit ZoneFinder(const SolidMesh& mesh);

  // The tetrahedra whose centroid is nearer to `centre_O` than `radius` [m], and those at the nodes
  // `touched`. O(N).
  [[nodiscard]] Zone Around(const Eigen::Vector3d& centre_O, double radius,
                            const std::vector<int>& touched) const;

 private:
  const SolidMesh& mesh_;
  std::vector<int> tets_at_;  // per node: how many tetrahedra have it
};

}  // namespace palpate
