// Scores the agreement of an estimated shape with a measured cloud.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate::study {

// Returns the similarity of two clouds (paper B, IV.C, figures 11 and 13): the share of `simulated`
// in the leaves of an octree around `measured` [-]. `leaf` [m]: their edge, 1 cm in the paper. For
// a flat face on a border of leaves half of the noisy points are in empty leaves; for a face in the
// middle of leaves hardly any. The score is therefore the mean over eight octrees, shifted by half
// a leaf along each axis, a quarter leaf to both sides of the cloud's centroid, so that it is
// independent of the frame's origin. Points must be finite. NaN: one cloud is empty.
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
  DistanceSummary measured_to_surface;      // distances of measured points from the estimate
  DistanceSummary simulated_to_measured;    // distances of simulated points from measured ones
};
// All in one frame; `leaf` [m] as in OctreeScore.
ShapeScore Score(std::span<const Eigen::Vector3d> measured,
                 std::span<const Eigen::Vector3d> simulated, const SurfaceMesh& estimate,
                 double leaf);

}  // namespace palpate::study
