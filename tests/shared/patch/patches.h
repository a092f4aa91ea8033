// Patches for tests.
#pragma once

#include "shared/patch/patch_place.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// The plane y = 0 with the compliance of a spring `K` [N/m], in every direction or along its
// normal.
inline SurfacePatch Plane(double K, int directions = 3) {
  SurfacePatch patch;
  patch.epoch = 1;
  patch.vertices_per_cell = patch.vertex_count = patch.node_count = 1;
  patch.vertices[0].setZero();
  patch.directions = directions;
  patch.compliance.setIdentity(directions, directions);
  patch.compliance *= static_cast<float>(1 / K);
  patch.full_depth = patch.valid_depth = 0.01;
  return patch;
}

// A roof of two lines that rise and fall by `slope`, its ridge at the origin, from x = -`reach` to
// `reach` [m]; the object lies below, the nodes at its three vertices are springs of stiffness `K`,
// and each displaces the others by the fraction `coupling`.
inline SurfacePatch Roof(double K, double coupling, int directions, double slope = 0,
                         double reach = 0.02) {
  SurfacePatch patch;
  patch.epoch = 1;
  patch.vertices_per_cell = 2;
  patch.vertex_count = patch.node_count = 3;
  patch.cell_count = 2;
  for (int i = 0; i < 3; ++i) {
    const double x = (1 - i) * reach;  // the body is to the left of each line
    const auto at = static_cast<std::size_t>(i);
    patch.vertices[at] = Eigen::Vector3d(x, -slope * std::abs(x), 0).cast<float>();
    patch.node_of[at] = static_cast<std::uint8_t>(i);
  }
  patch.cells[0] = {0, 1, 0};
  patch.cells[1] = {1, 2, 0};
  patch.directions = directions;
  patch.coupled = coupling != 0;
  patch.compliance.setZero(3 * directions, 3 * directions);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double share = i == j ? 1 : coupling;
      patch.compliance.block(directions * i, directions * j, directions, directions)
          .diagonal()
          .setConstant(static_cast<float>(share / K));
    }
  }
  patch.full_depth = patch.valid_depth = 0.01;
  MarkRim(&patch);
  return patch;
}

inline PatchLaw Law(const SurfacePatch& patch, std::uint32_t revision, double ratio = 1) {
  PatchLaw law;
  law.epoch = patch.epoch;
  law.revision = revision;
  law.ratios.fill(ratio);
  return law;
}

}  // namespace palpate
