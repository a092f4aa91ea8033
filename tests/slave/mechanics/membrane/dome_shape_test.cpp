#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "slave/mechanics/membrane/inflated_membrane.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

Ellipsoid Tilted() {
  Ellipsoid ellipsoid;
  ellipsoid.centre = {0.02, -0.01, 0.05};
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, 1, -0.3).normalized()).toRotationMatrix();
  ellipsoid.semi_axes = R * Eigen::Vector3d(0.06, 0.04, 0.045).asDiagonal() * R.transpose();
  return ellipsoid;
}

// Reference: the ideal surface. Every node lies on it, the rim in its plane, and triangle normals
// point outwards; a mesh of n rings has 1 + 3 n (n + 1) nodes and 6 n^2 triangles.
TEST(DomeShape, ADomesNodesLieOnTheEllipsoidAndItsRimInThePlane) {
  const Ellipsoid ellipsoid = Tilted();
  const Eigen::Vector3d axis = Eigen::Vector3d(0.1, 0.2, 1).normalized();
  const double rim = axis.dot(ellipsoid.centre) + 0.003;
  const MembraneShape shape = MeshDomedMembrane(ellipsoid, axis, rim, 9);
  EXPECT_EQ(shape.surface.nodes.size(), 1U + 3 * 9 * 10);
  EXPECT_EQ(shape.surface.triangles.size(), 6U * 81);
  EXPECT_EQ(shape.held.size(), 54U);
  for (const auto& p : shape.surface.nodes) EXPECT_NEAR(DistanceOutside(ellipsoid, p), 0, 1e-12);
  for (const int node : shape.held) {
    EXPECT_NEAR(axis.dot(shape.surface.nodes[Index(node)]), rim, 1e-9);
  }
  for (const auto& t : shape.surface.triangles) {
    const auto& p = shape.surface.nodes;
    const Eigen::Vector3d a = p[Index(t[0])];
    const Eigen::Vector3d n = (p[Index(t[1])] - a).cross(p[Index(t[2])] - a);
    EXPECT_GT(n.dot(a - ellipsoid.centre), 0);
  }
}

// A point outside by a millimetre, along the surface's normal.
TEST(DomeShape, DistanceIsMeasuredAlongTheNormal) {
  const Ellipsoid truth = Tilted();
  const Eigen::Vector3d on = truth.centre + truth.semi_axes * Eigen::Vector3d(0, 0, 1);
  const Eigen::Vector3d n =
      (truth.semi_axes.inverse() * truth.semi_axes.inverse() * (on - truth.centre)).normalized();
  EXPECT_NEAR(DistanceOutside(truth, on + 1e-3 * n), 1e-3, 0.05e-3);
}

TEST(DomeShape, WhatCannotBeIsRefused) {
  EXPECT_THROW(MeshFlatMembrane(0, 3), std::invalid_argument);
  EXPECT_THROW(MeshFlatMembrane(0.04, 0), std::invalid_argument);
  EXPECT_THROW(MeshDomedMembrane(Tilted(), {0, 0, 1}, 0.2, 4), std::invalid_argument);
  EXPECT_THROW(MeshDomedMembrane(Tilted(), {0, 0, 1}, -0.2, 4), std::invalid_argument);
  EXPECT_THROW(MeshDomedMembrane(Tilted(), {0, 0, 1}, std::nan(""), 4), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
