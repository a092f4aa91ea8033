// What contacts touch of a body of four-node or ten-node tetrahedra.
#pragma once

#include <vector>

#include "slave/mechanics/capacitance/contact_set.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate {

// Four nodes: see SurfaceNodePlaces. Ten: the same on the four quarters of every triangle, so that
// middles are moved as corners are; a load of a width acts on the middles alone, a third of each
// triangle's share on each, as even pressure does on quadratic triangles.
class TetPlaces final : public ContactPlaces {
 public:
  // Keeps a reference to `elements`, whose nodes are by `unit` [m]. `place_of_node`: per node, -1
  // for those that are not places. `uneven`: per node, see SurfaceFootprints.
  TetPlaces(const TetMesh& elements, double unit, const std::vector<int>& place_of_node,
            const std::vector<char>& uneven);

  // The contact's element is a triangle of the linear surface.
  std::string_view Find(const Contact& contact, ContactFootprint* footprint) override;
  void MayWiden(bool may) override {
    nodes_.MayWiden(may);
    triangles_.MayWiden(may);
  }

 private:
  [[nodiscard]] bool is_quadratic() const { return elements_.nodes_per_element == 10; }
  // The number of the quarter that is nearest to the contact.
  [[nodiscard]] int QuarterOf(const Contact& contact) const;
  std::string_view FindLoaded(const Contact& contact, ContactFootprint* footprint);

  const TetMesh& elements_;
  double unit_;
  SurfaceNodePlaces nodes_;
  SurfaceFootprints triangles_;
  std::vector<int> place_of_node_;
  std::vector<PlaceWeight> loaded_;  // triangles
  std::vector<double> load_;         // per node, zero between calls
};

}  // namespace palpate
