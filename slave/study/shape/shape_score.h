// How well an estimated shape agrees with a measured cloud.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate::study {

// How alike two clouds are (paper B, IV.C, figures 11 and 13): the share of `simulated` that lies
// in the leaves of an octree around `measured` [-]. `leaf` [m]: their edge, 1 cm in the paper. A
// flat face on a border of leaves has half of its noise in leaves that nothing occupies, one amid
// the leaves hardly any. The score is therefore the mean over eight octrees, each half a leaf from
// the next along each axis, a quarter to either side of the cloud's centroid: the same wherever the
// frame's origin lies. Points are finite. NaN: no points are given on one side.
double OctreeScore(std::span<const Eigen::Vector3d> measured,
                   std::span<const Eigen::Vector3d> simulated, double leaf);

// Statistics of unsigned distances [m]; NaN where there are none.
struct DistanceSummary {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double mean = kNone, rms = kNone, p95 = kNone, max = kNone;
};
// p95: the smallest that 95 % do not exceed.
DistanceSummary Summarised(std::vector<double> distances);

// Returns the distances from every point to the closest point of the surface, or of the cloud (in
// single precision). Points and nodes are finite. Empty surface or cloud: no distances.
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
// All in one frame; `leaf` [m] as in OctreeScore.
ShapeScore Score(std::span<const Eigen::Vector3d> measured,
                 std::span<const Eigen::Vector3d> simulated, const SurfaceMesh& estimate,
                 double leaf);

}  // namespace palpate::study
