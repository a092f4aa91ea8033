#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "slave/mechanics/membrane/inflated_membrane.h"
#include "tests/slave/mechanics/membrane/fit_ellipsoid.h"

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

// Reference: the ellipsoid that the points were put on, with 0.1 mm of noise, over 2000 points of
// its upper part; 5 % of them are thrown by 10 mm.
TEST(DomeShape, TheEllipsoidIsFoundAgainAmongNoiseAndOutliers) {
  const Ellipsoid truth = Tilted();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<Eigen::Vector3d> points;
  while (points.size() < 2000) {
    const Eigen::Vector3d s =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    if (s.z() < 0.1) continue;
    const double off = uniform(random) < 0.05 ? 0.01 : 1e-4 * normal(random);
    points.push_back(truth.centre + truth.semi_axes * s + off * s);
  }
  const Ellipsoid found = domes::FitEllipsoid(points, 0.2e-3);
  EXPECT_LT((found.centre - truth.centre).norm(), 0.3e-3);
  EXPECT_LT((found.semi_axes - truth.semi_axes).norm(), 0.5e-3);
  // A point outside by a millimetre, along the surface's normal.
  const Eigen::Vector3d on = truth.centre + truth.semi_axes * Eigen::Vector3d(0, 0, 1);
  const Eigen::Vector3d n =
      (truth.semi_axes.inverse() * truth.semi_axes.inverse() * (on - truth.centre)).normalized();
  EXPECT_NEAR(DistanceOutside(truth, on + 1e-3 * n), 1e-3, 0.05e-3);
  EXPECT_NEAR(DistanceOutside(found, on + 1e-3 * n), 1e-3, 0.2e-3);
}

// Reference: the surface itself. Every node lies on it, the rim in its plane, and triangles look
// outwards; a mesh of n rings has 1 + 3 n (n + 1) nodes and 6 n^2 triangles.
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
    EXPECT_NEAR(axis.dot(shape.surface.nodes[static_cast<std::size_t>(node)]), rim, 1e-9);
  }
  for (const auto& t : shape.surface.triangles) {
    const auto& p = shape.surface.nodes;
    const Eigen::Vector3d a = p[static_cast<std::size_t>(t[0])];
    const Eigen::Vector3d n =
        (p[static_cast<std::size_t>(t[1])] - a).cross(p[static_cast<std::size_t>(t[2])] - a);
    EXPECT_GT(n.dot(a - ellipsoid.centre), 0);
  }
}

// Reference: pi a^2, approached from inside by the polygon of 6 n sides.
TEST(DomeShape, AFlatMembraneCoversItsDisc) {
  const MembraneShape shape = MeshFlatMembrane(0.04, 12);
  double area = 0;
  for (const auto& t : shape.surface.triangles) {
    const auto& p = shape.surface.nodes;
    const Eigen::Vector3d a = p[static_cast<std::size_t>(t[0])];
    area +=
        (p[static_cast<std::size_t>(t[1])] - a).cross(p[static_cast<std::size_t>(t[2])] - a).z() /
        2;
  }
  const double sides = 72;
  EXPECT_NEAR(area, 0.04 * 0.04 * sides / 2 * std::sin(2 * std::numbers::pi / sides), 1e-12);
}

TEST(DomeShape, WhatCannotBeIsRefused) {
  EXPECT_THROW(MeshFlatMembrane(0, 3), std::invalid_argument);
  EXPECT_THROW(MeshFlatMembrane(0.04, 0), std::invalid_argument);
  EXPECT_THROW(MeshDomedMembrane(Tilted(), {0, 0, 1}, 0.2, 4), std::invalid_argument);
  EXPECT_THROW(MeshDomedMembrane(Tilted(), {0, 0, 1}, -0.2, 4), std::invalid_argument);
  EXPECT_THROW(MeshDomedMembrane(Tilted(), {0, 0, 1}, std::nan(""), 4), std::invalid_argument);
  std::vector<Eigen::Vector3d> points(8, {1, 2, 3});
  EXPECT_THROW(domes::FitEllipsoid(points, 1e-3), std::invalid_argument);
  // A flat grid is no ellipsoid.
  points.clear();
  for (int i = 0; i < 100; ++i) points.emplace_back(i % 10, i / 10, 1);
  EXPECT_THROW(domes::FitEllipsoid(points, 1e-3), std::invalid_argument);
  EXPECT_THROW(domes::FitEllipsoid(points, 0), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
