#include "slave/mechanics/fem/zone/zone.h"

#include "slave/mesh/index.h"

namespace palpate {

using Eigen::Vector3d;

ZoneFinder::ZoneFinder(const SolidMesh& mesh) : mesh_(mesh) {
  for (const auto& tet : mesh.tets) {
    Vector3d centroid = Vector3d::Zero();
    for (const int node : tet) centroid += mesh.nodes[Index(node)] / 4;
    centroids_.push_back(centroid);
  }
}

Zone ZoneFinder::Around(const Vector3d& centre_O, double radius, std::span<const Vector3d> others,
                        std::span<const int> touched, std::vector<char>* taken_before) const {
  std::vector<int> number(mesh_.nodes.size(), -1);
  Zone zone;
  const auto number_of = [&](int node) {
    int& known = number[Index(node)];
    if (known < 0) {
      known = zone.size();
      zone.nodes.push_back(node);
    }
    return known;
  };
  for (const int node : touched) number_of(node);
  const int contact_nodes = zone.size();
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
    const double distance = (centroids_[t] - centre_O).squaredNorm();
    bool taken = distance < radius * radius;
    for (const Vector3d& other : others) {
      taken = taken && distance <= (centroids_[t] - other).squaredNorm();
    }
    for (const int node : mesh_.tets[t]) {
      const int known = number[Index(node)];
      taken = taken || (known >= 0 && known < contact_nodes);
    }
    if (!taken || (*taken_before)[t] != 0) continue;
    (*taken_before)[t] = 1;
    zone.tets.push_back(static_cast<int>(t));
    zone.moduli.push_back(mesh_.ModulusOf(t));
    auto& corners = zone.corners.emplace_back();
    for (std::size_t v = 0; v < 4; ++v) corners[v] = number_of(mesh_.tets[t][v]);
  }
  return zone;
}

}  // namespace palpate
