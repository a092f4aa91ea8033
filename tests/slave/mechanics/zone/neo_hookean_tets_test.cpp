// Forces of the zone's tetrahedra against the general law's and by differences.
#include "slave/mechanics/fem/zone/neo_hookean_tets.h"

#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/material_law.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Eleven crooked tetrahedra, more than one group of eight.
struct Crooked {
  std::vector<Vector3d> nodes;
  std::vector<std::array<int, 4>> corners;
  VectorXd u;

  explicit Crooked(double strain) {
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int t = 0; t < 11; ++t) {
      const auto first = static_cast<int>(nodes.size());
      for (int v = 0; v < 4; ++v) {
        Vector3d p = v == 0 ? Vector3d::Zero() : Vector3d(Vector3d::Unit(v - 1));
        for (double& x : p) x += 0.2 * uniform(engine);
        nodes.push_back(p);
      }
      corners.push_back({first, first + 1, first + 2, first + 3});
    }
    u = VectorXd::NullaryExpr(3 * static_cast<int>(nodes.size()),
                              [&] { return strain * uniform(engine); });
  }
};

VectorXd ForceOf(const NeoHookeanTets& tets, const VectorXd& u) {
  VectorXd force = VectorXd::Zero(u.size());
  tets.AddForce(u.data(), force.data());
  return force;
}

// The same law in two formulations: equal to rounding.
TEST(NeoHookeanTets, ForcesAreThoseOfTheGeneralLaw) {
  const double nu = 0.42;
  for (const double strain : {1e-6, 0.01, 0.2}) {
    const Crooked crooked(strain);
    const NeoHookeanTets tets(crooked.corners, crooked.nodes, nu);
    const MaterialLaw law(FemOptions::Law::kNeoHookean, nu);
    const VectorXd force = ForceOf(tets, crooked.u);
    for (const auto& tet : crooked.corners) {
      Matrix3d edges, moved;
      for (int a = 0; a < 3; ++a) {
        const int from = tet[0], to = tet[Index(a + 1)];
        edges.col(a) = crooked.nodes[Index(to)] - crooked.nodes[Index(from)];
        moved.col(a) = crooked.u.segment<3>(3 * to) - crooked.u.segment<3>(3 * from);
      }
      const auto point = law.At(moved * edges.inverse());
      const Matrix3d P = point.stress + point.g / law.compressibility() * point.volume_stress;
      const Matrix3d forces = edges.determinant() / 6 * P * edges.inverse().transpose();
      for (int a = 0; a < 3; ++a) {
        EXPECT_LT((force.segment<3>(3 * tet[Index(a + 1)]) - forces.col(a)).norm(), 1e-14);
      }
      EXPECT_LT((force.segment<3>(3 * tet[0]) + forces.rowwise().sum()).norm(), 1e-14);
    }
  }
}

// Central differences with step 1e-6 truncate at 1e-12 and round at 1e-10: what the nonlinear force
// leaves out is the force's derivative at rest, Hooke's law.
TEST(NeoHookeanTets, TheNonlinearForceLacksTheLinearOne) {
  const Crooked crooked(0.3);
  const NeoHookeanTets tets(crooked.corners, crooked.nodes, 0.3);
  const double step = 1e-6;
  const VectorXd linear =
      (ForceOf(tets, step * crooked.u) - ForceOf(tets, -step * crooked.u)) / (2 * step);
  VectorXd nonlinear = VectorXd::Zero(crooked.u.size());
  tets.AddNonlinearForce(crooked.u.data(), nonlinear.data());
  EXPECT_LT((ForceOf(tets, crooked.u) - linear - nonlinear).norm(), 1e-8);
  EXPECT_GT(nonlinear.norm(), 0.05 * linear.norm());
}

// A mirror image of the first tetrahedron: det F is -1 there.
TEST(NeoHookeanTets, TheSmallestJacobianFindsAnInvertedElement) {
  Crooked crooked(0.01);
  const NeoHookeanTets tets(crooked.corners, crooked.nodes, 0.3);
  VectorXd force = VectorXd::Zero(crooked.u.size());
  EXPECT_GT(tets.AddNonlinearForce(crooked.u.data(), force.data()), 0.8);
  for (int v = 0; v < 4; ++v) crooked.u[3 * v] = -2 * crooked.nodes[Index(v)].x();
  for (int v = 0; v < 4; ++v) crooked.u.segment<2>(3 * v + 1).setZero();
  EXPECT_NEAR(tets.AddNonlinearForce(crooked.u.data(), force.data()), -1, 1e-12);
}

}  // namespace
}  // namespace palpate
