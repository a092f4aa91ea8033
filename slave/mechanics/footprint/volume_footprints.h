// Nodes of a body of four-node or ten-node tetrahedra that contacts touch (rules:
// slave/solve/README.md). All models of volumes use this rule.
#pragma once

#include <string_view>
#include <vector>

#include "slave/mechanics/footprint/contact_footprint.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate {

// Four nodes: see SurfaceFootprints. Ten: the same on the four quarters of every triangle, so that
// middles are moved as corners are; a load of a width acts on the middles alone, a third of each
// triangle's share on each, as even pressure does on quadratic triangles.
class VolumeFootprints {
 public:
  // Keeps a reference to `mesh`, whose nodes are by `unit` [m]. `uneven`: per node, see
  // SurfaceFootprints; empty: nothing is widened.
  VolumeFootprints(const TetMesh& mesh, double unit, const std::vector<char>& uneven);

  // SurfaceFootprints::OnNodes; the contact's element is a triangle of the linear surface.
  std::string_view OnNodes(const Contact& contact, ContactFootprint* footprint);
  void MayWiden(bool may) {
    nodes_.MayWiden(may);
    triangles_.MayWiden(may);
  }

 private:
  [[nodiscard]] bool is_quadratic() const { return mesh_.nodes_per_element == 10; }
  // The number of the quarter that is nearest to the contact.
  [[nodiscard]] int QuarterOf(const Contact& contact) const;
  std::string_view FindLoaded(const Contact& contact, ContactFootprint* footprint);

  const TetMesh& mesh_;
  double unit_;
  SurfaceFootprints nodes_, triangles_;
  std::vector<PlaceWeight> loaded_;  // room: triangles
  std::vector<double> load_;         // per node, zero between calls
};

}  // namespace palpate
