// Points as a depth camera measures them, thinned out, and their neighbours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace palpate::study {

// Every point is finite; `colours` and `labels` have one entry per point, or none at all.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;               // [m]; the user defines the frame
  std::vector<std::array<std::uint8_t, 3>> colours;  // red, green, blue
  std::vector<std::uint32_t> labels;                 // label of the object that contains the point

  [[nodiscard]] std::size_t size() const { return points.size(); }
};

// Mean of the finite points [m]; zero: there are none.
Eigen::Vector3d CentroidOf(std::span<const Eigen::Vector3d> points) noexcept;

// The cell of edge `edge` [m] that `p` lies in, as one number; cells are [k edge, (k + 1) edge) in
// each axis. nullopt: not finite, or 2^20 cells or more from the origin.
std::optional<std::uint64_t> CellOf(const Eigen::Vector3d& p, double edge) noexcept;
// Its lower corner [m].
Eigen::Vector3d CornerOf(std::uint64_t cell, double edge) noexcept;

// A cloud thinned out: one point for each occupied cell of a cubic grid.
struct VoxelCloud {
  PointCloud cloud;                    // mean position and colour of each cell's points; no labels
  std::vector<std::size_t> voxel_of;   // per point of the cloud that was thinned out
  std::vector<std::size_t> points_in;  // per voxel
};

// Voxels in the order of their first points. Throws std::invalid_argument: a point too far out for
// cells so small.
VoxelCloud Voxelised(const PointCloud& cloud, double edge);

// Finds the neighbours of points. Const members are thread-safe. Distances are exact to single
// precision.
class PointTree {
 public:
  // O(N log N). Throws std::invalid_argument: no points, or one that is not finite.
  explicit PointTree(std::span<const Eigen::Vector3d> points);
  ~PointTree();

  struct Neighbour {
    std::size_t index = 0;
    double distance = 0;  // [m]
  };
  // `p` must be finite.
  [[nodiscard]] Neighbour Nearest(const Eigen::Vector3d& p) const;
  // Distance from one of the tree's own points to the next of them that is elsewhere [m]; 0: many
  // are there.
  [[nodiscard]] double NextTo(const Eigen::Vector3d& p) const;
  // Those within `radius` [m], in no particular order.
  void Within(const Eigen::Vector3d& p, double radius, std::vector<std::size_t>* indices) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

// Surface properties from the neighbours of a point.
struct NeighbourhoodShape {
  // Offset of the neighbours' centroid, relative to the radius: tangential, 0 to 1, 0.42 on a
  // straight edge where the surface ends; along the normal, which points to the camera, -1 to 1,
  // 0.30 in a right-angled groove, negative on ridges.
  double beside = 0, before = 0;
  std::size_t neighbours = 0;
};

// `radius` [m] is that of the neighbourhood; the pupil is at the origin. O(N neighbours).
std::vector<NeighbourhoodShape> NeighbourhoodShapes(std::span<const Eigen::Vector3d> points,
                                                    const PointTree& tree, double radius);

}  // namespace palpate::study
