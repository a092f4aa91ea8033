#include "slave/study/shape/shape_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "slave/contact/surface_contact.h"
#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

OctreeLeaves::OctreeLeaves(std::span<const Eigen::Vector3d> cloud, double leaf,
                           const Eigen::Vector3d& corner)
    : leaf_(leaf), corner_(corner) {
  if (!(leaf > 0 && leaf < std::numeric_limits<double>::infinity())) {
    throw std::invalid_argument("leaf = " + std::to_string(leaf) + " m: accepted is > 0");
  }
  for (const auto& p : cloud) {
    if (const auto cell = CellOf(p - corner_, leaf_)) cells_.insert(*cell);
  }
}

bool OctreeLeaves::Contains(const Eigen::Vector3d& p) const noexcept {
  const auto cell = CellOf(p - corner_, leaf_);
  return cell && cells_.contains(*cell);
}

double OctreeLeaves::Share(std::span<const Eigen::Vector3d> points) const noexcept {
  if (points.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto inside = std::ranges::count_if(points, [&](const auto& p) { return Contains(p); });
  return static_cast<double>(inside) / static_cast<double>(points.size());
}

std::vector<Eigen::Vector3d> OctreeLeaves::corners() const {
  std::vector<Eigen::Vector3d> corners;
  for (const std::uint64_t cell : cells_) corners.emplace_back(corner_ + CornerOf(cell, leaf_));
  return corners;
}

std::array<Eigen::Vector3d, 8> LatticeCorners(std::span<const Eigen::Vector3d> cloud, double leaf) {
  const Eigen::Vector3d centroid = CentroidOf(cloud);
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const auto side = [&](std::size_t bit) { return (k & bit) != 0 ? 0.25 : -0.25; };
    corners[k] = centroid + leaf * Eigen::Vector3d(side(1), side(2), side(4));
  }
  return corners;
}

double OctreeScore(std::span<const Eigen::Vector3d> measured,
                   std::span<const Eigen::Vector3d> simulated, double leaf) {
  if (measured.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto corners = LatticeCorners(measured, leaf);
  double sum = 0;
  for (const auto& corner : corners) sum += OctreeLeaves(measured, leaf, corner).Share(simulated);
  return sum / static_cast<double>(corners.size());
}

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

std::vector<LabelScore> ScoreLabels(const PointCloud& cloud, const Segmentation& segmentation) {
  std::map<std::uint32_t, std::size_t> points, support;
  std::map<std::pair<std::uint32_t, int>, std::size_t> shared;
  for (std::size_t i = 0; i < cloud.labels.size(); ++i) {
    ++points[cloud.labels[i]];
    if (!segmentation.in_support.empty() && segmentation.in_support[i]) ++support[cloud.labels[i]];
    if (segmentation.region_of[i] >= 0) ++shared[{cloud.labels[i], segmentation.region_of[i]}];
  }
  std::map<std::uint32_t, LabelScore> scores;
  for (const auto& [label, count] : points)
    scores[label] = {label, count, -1, 0, 2 * support[label] > count};
  for (const auto& [pair, both] : shared) {
    LabelScore& score = scores[pair.first];
    if (score.support) continue;
    const std::size_t all =
        score.points + segmentation.size[static_cast<std::size_t>(pair.second)] - both;
    const double iou = static_cast<double>(both) / static_cast<double>(all);
    if (iou > score.iou) score.iou = iou, score.region = pair.second;
  }
  std::vector<LabelScore> rows;
  for (const auto& [label, score] : scores) rows.push_back(score);
  return rows;
}

}  // namespace palpate::study
