#include "slave/reference/membrane/neo_hookean_disc.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace palpate::site {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

class NeoHookeanDiscTest : public testing::TestWithParam<double> {
 protected:
  // Unit radius, two layers; at the centre a quarter, else a half.
  DiscMesh mesh_{{1, 0.1, GetParam()}, 0.05, {1, 3, 3, 2}};
  NeoHookeanDisc disc_{mesh_, 0.45};

  // The z of a level [radii].
  [[nodiscard]] double Height(int level) const {
    return mesh_.thickness() * (static_cast<double>(level) / (mesh_.levels() - 1) - 0.5);
  }
};

// Reference: central differences of the forces in a random direction from a random, strained state
// (steps of 1e-6 of the thickness: their error is 1e-9). The stored triangle represents both, so
// this also says that the derivative is symmetric: the forces have a potential.
TEST_P(NeoHookeanDiscTest, StiffnessIsTheDerivativeOfTheForces) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  VectorXd free;
  NeoHookeanDisc::Matrix stiffness = disc_.EmptyMatrix();
  VectorXd u(disc_.size()), v(disc_.size()), forces, up, down;
  for (auto& x : u) x = 2e-4 * normal(random);
  for (auto& x : v) x = normal(random);
  ASSERT_TRUE(disc_.Linearise(u, &forces, &stiffness));
  for (int circle = 0; circle + 1 < mesh_.circle_lines(); ++circle) {
    for (int ray = 0; ray < mesh_.ray_lines(); ++ray) {
      for (int i = 0; i < 3 * mesh_.levels(); ++i) {
        const bool held = mesh_.Held(circle, ray)[static_cast<std::size_t>(i % 3)];
        if (held) v[disc_.unknown(mesh_.column(circle, ray), i / 3, i % 3)] = 0;
      }
    }
  }
  const double h = 5e-8;
  ASSERT_TRUE(disc_.Forces(u + h * v, &up) && disc_.Forces(u - h * v, &down));
  const VectorXd expected = (up - down) / (2 * h);
  const VectorXd found = stiffness.selfadjointView<Eigen::Upper>() * v;
  EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
  EXPECT_GT(forces.norm(), 0);
}

// Reference: objectivity. All elements but those at the clamped rim turned by a tenth of a
// radian about an axis that the mirror plane allows, y: what is inside bears no force. Tolerance:
// rounding.
TEST_P(NeoHookeanDiscTest, TurningCostsNoForce) {
  const auto R = Eigen::AngleAxisd(0.1, Vector3d::UnitY()).toRotationMatrix();
  VectorXd u(disc_.size()), forces;
  for (int column = 0; column < mesh_.free_columns(); ++column) {
    for (int level = 0; level < mesh_.levels(); ++level) {
      const Vector3d X(mesh_.place(column).x(), mesh_.place(column).y(), Height(level));
      u.segment<3>(disc_.unknown(column, level, 0)) = R * X - X;
    }
  }
  ASSERT_TRUE(disc_.Forces(u, &forces));
  for (int circle = 0; circle + DiscMesh::kAcross + 1 < mesh_.circle_lines(); ++circle) {
    for (int ray = 0; ray < mesh_.ray_lines(); ++ray) {
      const int first = disc_.unknown(mesh_.column(circle, ray), 0, 0);
      EXPECT_LT(forces.segment(first, 3 * mesh_.levels()).lpNorm<Eigen::Infinity>(), 1e-14);
    }
  }
}

// Reference: an even pressure of one over the tool's disc: its resultant and its first moments, of
// the half or quarter that is meshed. Tolerance: cubic sides of the circle, 1e-4 of its area.
TEST_P(NeoHookeanDiscTest, ToolPressesEvenly) {
  const VectorXd load = disc_.ToolLoad();
  Vector3d moments(0, 0, 0);
  for (int column = 0; column < mesh_.free_columns(); ++column) {
    const double f = load[disc_.unknown(column, mesh_.levels() - 1, 2)];
    moments += f * Vector3d(1, mesh_.place(column).x(), mesh_.place(column).y());
  }
  const double part = mesh_.is_quarter() ? 0.25 : 0.5;
  const double lever = 4 * 0.1 / (3 * M_PI);  // of half a disc
  EXPECT_NEAR(moments[0], -part, 1e-12);
  EXPECT_NEAR(moments[1], -part * (mesh_.is_quarter() ? lever : GetParam()), 1e-5);
  EXPECT_NEAR(moments[2], -part * lever, 1e-5);
  EXPECT_NEAR(load.sum(), moments[0], 1e-12) << "along z on the outer face only";
}

INSTANTIATE_TEST_SUITE_P(CentreAndBeside, NeoHookeanDiscTest, testing::Values(0.0, 0.5));

}  // namespace
}  // namespace palpate::site
