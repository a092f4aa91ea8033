// The patch that a slave with a flat wall would send.
#pragma once

#include "master/haptics/received.h"
#include "shared/patch/patch_place.h"

namespace palpate {

// A line of 40 mm along x at height `surface` [m], of stiffness `K` [N/m] along its normal.
inline ReceivedPatch WallPatch(double K, std::uint32_t epoch, double surface = -0.004) {
  ReceivedPatch wall;
  SurfacePatch& patch = wall.patch;
  patch.epoch = wall.law.epoch = epoch;
  wall.law.revision = 1;
  wall.law.sensed_at = Time{std::chrono::hours(1)};
  patch.vertex_count = 2;
  patch.cell_count = patch.node_count = 1;
  patch.vertices[0] = Eigen::Vector3d(0.02, surface, 0).cast<float>();
  patch.vertices[1] = Eigen::Vector3d(-0.02, surface, 0).cast<float>();
  patch.cells[0] = {0, 1, 0};
  patch.directions = 1;
  patch.compliance.setConstant(1, 1, static_cast<float>(1 / K));
  patch.full_depth = patch.valid_depth = 0.01;
  MarkRim(&patch);
  return wall;
}

}  // namespace palpate
