// A cloud thinned out: one point for each occupied cell of a cubic grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

// The cell of edge `edge` [m] that `p` lies in, as one number; cells are [k edge, (k + 1) edge) in
// each axis. nullopt: not finite, or 2^20 cells or more from the origin.
std::optional<std::uint64_t> CellOf(const Eigen::Vector3d& p, double edge) noexcept;
// Its lower corner [m].
Eigen::Vector3d CornerOf(std::uint64_t cell, double edge) noexcept;

struct VoxelCloud {
  PointCloud cloud;                    // mean place and colour of each cell's points; no labels
  std::vector<std::size_t> voxel_of;   // per point of the cloud that was thinned out
  std::vector<std::size_t> points_in;  // per voxel
};

// Voxels in the order of their first points. Throws std::invalid_argument: a point too far out for
// cells so small.
VoxelCloud Voxelised(const PointCloud& cloud, double edge);

}  // namespace palpate::study
