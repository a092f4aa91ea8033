// Pressures on a domed membrane for tests.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {

struct Pressure {
  Eigen::Vector3d p_O;
  double force = 0;  // inward [N]
};

// Displacements of the nodes under pressures that are even on discs of `width` with a soft edge
// [m].
inline std::vector<Eigen::Vector3d> DisplacementsUnder(const std::vector<Pressure>& pressures,
                                                       double width,
                                                       const InflatedMembrane& membrane) {
  const auto& nodes = membrane.surface().nodes;
  std::vector<Eigen::Vector3d> f(nodes.size(), Eigen::Vector3d::Zero()), u;
  for (const Pressure& pressure : pressures) {
    std::vector<Eigen::Vector3d> own(nodes.size());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const double beyond = (nodes[i] - pressure.p_O).norm() - width / 2;
      own[i] =
          -std::clamp(0.5 - beyond / 2e-3, 0.0, 1.0) * membrane.areas()[i] * membrane.normals()[i];
      sum += own[i];
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) f[i] += pressure.force / sum.norm() * own[i];
  }
  membrane.Displace(f, &u);
  return u;
}

}  // namespace palpate
