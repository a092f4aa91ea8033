// How alike two clouds are (paper B, IV.C, figures 11 and 13): the share of one's points that lie
// inside the leaves of an octree around the other.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// The leaves of an octree of which all are divided down to one size are the occupied cells of a
// grid; its corner is the frame's origin, so that no cloud moves it.
class OctreeLeaves {
 public:
  // `leaf` [m]: their edge, 1 cm in the paper. Points that are not finite are left out. O(N).
  // Throws std::invalid_argument: leaf not positive and finite.
  explicit OctreeLeaves(std::span<const Eigen::Vector3d> cloud, double leaf = 0.01);

  [[nodiscard]] bool Contains(const Eigen::Vector3d& p) const noexcept;
  // Share of the points that lie inside leaves [-]; those that are not finite do not. NaN: none are
  // given.
  [[nodiscard]] double Share(std::span<const Eigen::Vector3d> points) const noexcept;
  // Lower corners of the leaves [m], in no particular order.
  [[nodiscard]] std::vector<Eigen::Vector3d> corners() const;
  [[nodiscard]] double leaf() const noexcept { return leaf_; }

 private:
  double leaf_;
  std::unordered_set<std::uint64_t> cells_;
};

}  // namespace palpate
