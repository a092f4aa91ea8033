// Bodies, contacts and reference cases that the tests of `fem` share.
#pragma once

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/fem_model.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/support/fixed_nodes.h"
#include "tests/support/references.h"

namespace palpate::solids {

using Held = std::vector<std::array<bool, 3>>;
using contacts::Displacement;
using contacts::Respond;
using Eigen::Vector3d;
using reference::VectorOf;

inline int NodeAt(const SolidMesh& mesh, const Vector3d& p) {
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    if ((mesh.nodes[i] - p).norm() < 1e-9) return static_cast<int>(i);
  }
  ADD_FAILURE() << "no node at " << p.transpose();
  return 0;
}

// A load at a node.
inline Contact Push(const SolidMesh& mesh, int node, const Vector3d& force) {
  return contacts::Push(mesh.nodes[static_cast<std::size_t>(node)], force);
}

inline FemModel::Params Foam() {
  return {.material = {.young_modulus = 3800, .poisson_ratio = 0.15, .density = 45},
          .options = {.residual = 1e-12}};
}
inline FemModel::Params Linear(FemModel::Params params) {
  params.options.law = FemOptions::Law::kLinear;
  return params;
}

// Largest difference, relative to the largest displacement.
inline double Difference(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  EXPECT_EQ(a.size(), b.size());
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    difference = std::max(difference, (a[i] - b[i]).lpNorm<Eigen::Infinity>());
    size = std::max(size, b[i].lpNorm<Eigen::Infinity>());
  }
  return size > 0 ? difference / size : difference;
}

}  // namespace palpate::solids
