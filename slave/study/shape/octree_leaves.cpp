#include "slave/study/shape/octree_leaves.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "slave/study/shape/voxel_grid.h"

namespace palpate {

OctreeLeaves::OctreeLeaves(std::span<const Eigen::Vector3d> cloud, double leaf) : leaf_(leaf) {
  if (!(leaf > 0 && leaf < std::numeric_limits<double>::infinity())) {
    throw std::invalid_argument("leaf = " + std::to_string(leaf) + " m: accepted is > 0");
  }
  for (const auto& p : cloud) {
    if (const auto cell = CellOf(p, leaf_)) cells_.insert(*cell);
  }
}

bool OctreeLeaves::Contains(const Eigen::Vector3d& p) const noexcept {
  const auto cell = CellOf(p, leaf_);
  return cell && cells_.contains(*cell);
}

double OctreeLeaves::Share(std::span<const Eigen::Vector3d> points) const noexcept {
  if (points.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto inside = std::ranges::count_if(points, [&](const auto& p) { return Contains(p); });
  return static_cast<double>(inside) / static_cast<double>(points.size());
}

std::vector<Eigen::Vector3d> OctreeLeaves::corners() const {
  std::vector<Eigen::Vector3d> corners;
  for (const std::uint64_t cell : cells_) corners.push_back(CornerOf(cell, leaf_));
  return corners;
}

}  // namespace palpate
