// What a contact touches of a triangulated surface, and with what shares (contracts, `solve`): the
// one rule of all models of volumes.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/footprint/surface_finder.h"

namespace palpate {

struct PlaceWeight {
  int place = -1;     // a node or a triangle of a surface, a place of a Compliance
  double weight = 0;  // share [-]
};

// What one contact touches.
//
// A load's force is shared out by the weights, which sum to one, and the displacement reported is
// the mean by the same weights (the work is then force times displacement). So is a contact that
// acts as a `point`: one unknown force, the weighted mean is prescribed. Otherwise every place is
// moved alike with an unknown force of its own, and the weights do not count.
struct ContactFootprint {
  std::vector<PlaceWeight> places;
  bool point = true;                  // at most kMostPointPlaces places
  Eigen::Vector3d normal_O{0, 0, 0};  // outward, unit; the direction of frictionless contacts
  bool coarse = false;                // IsPatchCoarse (mesh_resolution.h)
  SurfacePlace at;                    // where the contact's centre meets the surface
};
constexpr int kMostPointPlaces = 3;

// Contacts on one surface. Both answer empty: found, or why not, one clause that lives on; both
// allocate nothing where the footprint has room already. The contact is finite; its kind, p_O,
// element and width count, its value does not.
class SurfaceFootprints {
 public:
  explicit SurfaceFootprints(SurfaceMesh surface)
      : finder_(std::move(surface)), load_(finder_.surface().nodes.size(), 0) {}

  // A contact moves a node, a point between three, or the nodes of a disc alike; a load acts on a
  // node, on three by their barycentric weights, or evenly on the triangles of a disc, a third of
  // each one's share per node. A point has the three nodes of its triangle, those of no weight too;
  // nodes of a disc are in rising order.
  std::string_view OnNodes(const Contact& contact, ContactFootprint* footprint);
  // Triangles are moved or loaded evenly: without width one, of a disc all whose centroids lie in
  // it, in rising order.
  std::string_view OnTriangles(const Contact& contact, ContactFootprint* footprint);

  [[nodiscard]] const SurfaceMesh& surface() const { return finder_.surface(); }
  // Of the last contact that had a width.
  [[nodiscard]] const SurfacePatch& patch() const { return finder_.patch(); }

 private:
  void ShareAmongNodes(ContactFootprint* footprint);

  SurfaceFinder finder_;
  std::vector<double> load_;  // per node, zero between calls
};

}  // namespace palpate
