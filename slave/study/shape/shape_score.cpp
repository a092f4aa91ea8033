#include "slave/study/shape/shape_score.h"

#include <algorithm>
#include <cmath>

#include "slave/contact/surface_contact.h"
#include "slave/study/clouds/octree_leaves.h"
#include "slave/study/clouds/point_tree.h"

namespace palpate::study {

DistanceSummary Summarised(std::vector<double> distances) {
  if (distances.empty()) return {};
  const auto n = static_cast<double>(distances.size());
  double sum = 0, squares = 0;
  for (const double d : distances) sum += d, squares += d * d;
  std::ranges::sort(distances);
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * n)) - 1;
  return {sum / n, std::sqrt(squares / n), distances[rank], distances.back()};
}

std::vector<double> DistancesToSurface(std::span<const Eigen::Vector3d> points,
                                       const SurfaceMesh& surface) {
  SurfaceMesh sound{surface.nodes, {}};
  for (const auto& triangle : surface.triangles) {
    const bool finite = std::ranges::all_of(
        triangle, [&](int i) { return surface.nodes[static_cast<std::size_t>(i)].allFinite(); });
    if (finite) sound.triangles.push_back(triangle);
  }
  std::vector<double> distances;
  if (sound.triangles.empty()) return distances;
  const SurfaceContact places(std::move(sound));
  for (const auto& p : points) {
    if (const auto place = places.Find(p, std::numeric_limits<double>::max())) {
      distances.push_back(place->distance);
    }
  }
  return distances;
}

std::vector<double> DistancesToCloud(std::span<const Eigen::Vector3d> points,
                                     std::span<const Eigen::Vector3d> cloud) {
  std::vector<Eigen::Vector3d> sound;
  for (const auto& p : cloud) {
    if (p.allFinite()) sound.push_back(p);
  }
  std::vector<double> distances;
  if (sound.empty()) return distances;
  const PointTree tree(sound);
  for (const auto& p : points) {
    if (p.allFinite()) distances.push_back(tree.Nearest(p).distance);
  }
  return distances;
}

ShapeScore Score(std::span<const Eigen::Vector3d> measured,
                 std::span<const Eigen::Vector3d> simulated, const SurfaceMesh& estimate,
                 double leaf) {
  return {OctreeScore(measured, simulated, leaf), measured.size(), simulated.size(),
          Summarised(DistancesToSurface(measured, estimate)),
          Summarised(DistancesToCloud(simulated, measured))};
}

}  // namespace palpate::study
