// Nodes of a body of four-node or ten-node tetrahedra that contacts touch (rules:
// slave/solve/README.md). All models of volumes use this rule.
#pragma once

#include <string_view>
#include <vector>

#include "slave/mechanics/footprint/contact_footprint.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate {

// Four-node elements: see SurfaceFootprints. Ten-node elements: the same on the four quarters of
// every triangle, so that mid-edge nodes are moved like corners. A load with a width acts only on
// mid-edge nodes, each with a third of its triangle's share, as a uniform pressure does on
// quadratic triangles.
class VolumeFootprints {
 public:
  // Stores a reference to `mesh`, whose nodes are in units of `unit` [m]. `uneven`: per node, see
  // `held` of SurfaceFootprints; empty: no contact is widened.
  VolumeFootprints(const TetMesh& mesh, double unit, const std::vector<char>& uneven);

  // SurfaceFootprints::OnNodes; the contact's element is a triangle of the linear surface.
  std::string_view OnNodes(const Contact& contact, ContactFootprint* footprint);
  // SurfaceFootprints::OnTool; the contact's element is a triangle of the linear surface.
  std::string_view OnTool(const Contact& contact, bool whole, ContactFootprint* footprint);
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
  std::vector<PlaceWeight> loaded_;  // scratch: triangles
  std::vector<double> load_;         // per node, zero between calls
};

}  // namespace palpate
