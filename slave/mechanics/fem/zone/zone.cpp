#include "slave/mechanics/fem/zone/zone.h"

#include <algorithm>

#include "shared/geometry/index.h"

namespace palpate {

int Zone::Find(int node) const {
  const auto found = std::ranges::find(nodes, node);
  return found == nodes.end() ? -1 : static_cast<int>(found - nodes.begin());
}

ZoneFinder::ZoneFinder(const SolidMesh& mesh) : mesh_(mesh), tets_at_(mesh.nodes.size(), 0) {
  for (const auto& tet : mesh.tets) {
    for (const int node : tet) ++tets_at_[Index(node)];
  }
}

Zone ZoneFinder::Around(const Eigen::Vector3d& centre_O, double radius,
                        const std::vector<int>& touched) const {
  std::vector<char> is_touched(mesh_.nodes.size(), 0);
  for (const int node : touched) is_touched[Index(node)] = 1;
  std::vector<int> inside(mesh_.nodes.size(), 0);  // tetrahedra of the zone per node
  Zone zone;
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
    bool taken = false;
    for (const int node : mesh_.tets[t]) {
      centroid += mesh_.nodes[Index(node)] / 4;
      taken = taken || is_touched[Index(node)];
    }
    if (!taken && (centroid - centre_O).norm() >= radius) continue;
    zone.tets.push_back(static_cast<int>(t));
    for (const int node : mesh_.tets[t]) ++inside[Index(node)];
  }
  std::vector<int> border, number(mesh_.nodes.size(), -1);
  for (std::size_t n = 0; n < inside.size(); ++n) {
    if (inside[n] == 0) continue;
    (inside[n] == tets_at_[n] ? zone.nodes : border).push_back(static_cast<int>(n));
  }
  zone.inner = zone.size();
  zone.nodes.insert(zone.nodes.end(), border.begin(), border.end());
  for (int i = 0; i < zone.size(); ++i) number[Index(zone.nodes[Index(i)])] = i;
  for (const int t : zone.tets) {
    std::array<int, 4> corners{};
    for (std::size_t v = 0; v < 4; ++v) corners[v] = number[Index(mesh_.tets[Index(t)][v])];
    zone.corners.push_back(corners);
  }
  return zone;
}

}  // namespace palpate
