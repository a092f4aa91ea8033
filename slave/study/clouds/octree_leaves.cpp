#include "slave/study/clouds/octree_leaves.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "slave/study/clouds/voxel_grid.h"

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
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const auto& p : cloud) {
    if (p.allFinite()) sum += p, count += 1;
  }
  const Eigen::Vector3d centroid = sum / std::max(1.0, count);
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

}  // namespace palpate::study
