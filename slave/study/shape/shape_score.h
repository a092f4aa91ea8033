// How well an estimated shape agrees with a measured cloud.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/study/clouds/point_cloud.h"
#include "slave/study/clouds/segmentation.h"

namespace palpate::study {

// The leaves of an octree of which all are divided down to one size are the occupied cells of a
// grid.
//
// How alike two clouds are (paper B, IV.C, figures 11 and 13): the share of one's points that lie
// inside the leaves of an octree around the other. Where the leaves' borders lie decides much of
// it: a flat face on a border has half of its noise in leaves that nothing occupies, one amid the
// leaves hardly any. OctreeScore therefore asks eight octrees whose lattice the cloud itself
// carries with it.
class OctreeLeaves {
 public:
  // `leaf` [m]: their edge, 1 cm in the paper; `corner` [m]: a corner of the grid. Points that are
  // not finite are left out. O(N). Throws std::invalid_argument: leaf not positive and finite.
  explicit OctreeLeaves(std::span<const Eigen::Vector3d> cloud, double leaf = 0.01,
                        const Eigen::Vector3d& corner = Eigen::Vector3d::Zero());

  [[nodiscard]] bool Contains(const Eigen::Vector3d& p) const noexcept;
  // Share of the points that lie inside leaves [-]; those that are not finite do not. NaN: none are
  // given.
  [[nodiscard]] double Share(std::span<const Eigen::Vector3d> points) const noexcept;
  // Lower corners of the leaves [m], in no particular order.
  [[nodiscard]] std::vector<Eigen::Vector3d> corners() const;
  [[nodiscard]] double leaf() const noexcept { return leaf_; }

 private:
  double leaf_;
  Eigen::Vector3d corner_;
  std::unordered_set<std::uint64_t> cells_;
};

// Corners of eight grids, each half a leaf from the next along each axis, a quarter to either side
// of the cloud's centroid [m]: they move with the cloud. Points that are not finite are left out.
std::array<Eigen::Vector3d, 8> LatticeCorners(std::span<const Eigen::Vector3d> cloud, double leaf);

// Mean of `Share` over the octrees of `measured` on these eight grids [-]: the same wherever the
// frame's origin lies. NaN: no points are given on one side. Throws as OctreeLeaves.
double OctreeScore(std::span<const Eigen::Vector3d> measured,
                   std::span<const Eigen::Vector3d> simulated, double leaf);

// Of unsigned distances [m]; NaN where there are none.
struct DistanceSummary {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double mean = kNone, rms = kNone, p95 = kNone, max = kNone;
};
// p95: the smallest that 95 % do not exceed.
DistanceSummary Summarised(std::vector<double> distances);

// From every point to the closest point of the surface, or of the cloud. Points and nodes that are
// not finite are left out; empty surface or cloud: no distances.
std::vector<double> DistancesToSurface(std::span<const Eigen::Vector3d> points,
                                       const SurfaceMesh& surface);
std::vector<double> DistancesToCloud(std::span<const Eigen::Vector3d> points,
                                     std::span<const Eigen::Vector3d> cloud);

struct ShapeScore {
  double octree = DistanceSummary::kNone;   // OctreeScore [-]
  std::size_t measured = 0, simulated = 0;  // points
  DistanceSummary measured_to_surface;      // how far measured points are from the estimate
  DistanceSummary simulated_to_measured;    // how far simulated points are from measured ones
};
// All in one frame; `leaf` [m] as in OctreeLeaves.
ShapeScore Score(std::span<const Eigen::Vector3d> measured,
                 std::span<const Eigen::Vector3d> simulated, const SurfaceMesh& estimate,
                 double leaf);

// How well a segmentation agrees with a cloud whose points are labelled.
struct LabelScore {
  std::uint32_t label = 0;
  std::size_t points = 0;
  int region = -1;  // that shares most with it; -1: none does
  double iou = 0;   // intersection over union with that region [-]
  bool support =
      false;  // more than half of it lies in supporting planes: not an object, not scored
};

// One row per label, ascending. Empty: the cloud has no labels.
std::vector<LabelScore> ScoreLabels(const PointCloud& cloud, const Segmentation& segmentation);

}  // namespace palpate::study
