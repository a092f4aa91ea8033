// Single elements: stiffness, rotations, inversion, and the exact tangent.
#include "slave/mechanics/fem/tet_elements.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/signed_polar.h"
#include "slave/mesh/index.h"
#include "tests/slave/mechanics/fem/solids.h"

namespace palpate::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector12d = Eigen::Matrix<double, 12, 1>;

const SolidMesh kUnitTet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
constexpr auto kCorotational = TetElements::Law::kCorotational;
constexpr auto kLinear = TetElements::Law::kLinear;

FemBody UnitTet(TetElements::Law law, double nu = 0.25) {
  return FemBody(kUnitTet, solids::Held(4), {.poisson_ratio = nu, .law = law});
}

// Returns the displacements that move the nodes of the mesh to `x`.
NodeVector DisplacementTo(const FemBody& body, const std::array<Vector3d, 4>& x) {
  NodeVector u(4);
  for (int a = 0; a < 4; ++a) {
    Eigen::Map<Vector3d>(At(u, body.Number(a)).v) = x[Index(a)] - kUnitTet.nodes[Index(a)];
  }
  return u;
}

// Internal forces with the nodes of the mesh at `x`, node by node.
Vector12d ForcesAt(FemBody& body, const std::array<Vector3d, 4>& x) {
  NodeVector f(4);
  body.Evaluate(DisplacementTo(body, x));
  body.InternalForce(f);
  Vector12d forces;
  for (int a = 0; a < 4; ++a) {
    for (int c = 0; c < 3; ++c) forces[3 * a + c] = At(f, body.Number(a)).v[c];
  }
  return forces;
}

std::array<Vector3d, 4> Deformed(const Matrix3d& F, const Vector3d& t = {0, 0, 0}) {
  std::array<Vector3d, 4> x;
  for (std::size_t a = 0; a < 4; ++a) x[a] = F * kUnitTet.nodes[a] + t;
  return x;
}

void ExpectForces(const Vector12d& forces, const nlohmann::json& expected, double tolerance) {
  for (int a = 0; a < 4; ++a) {
    const Vector3d f = solids::VectorOf(expected.at(Index(a)));
    EXPECT_LT((forces.segment<3>(3 * a) - f).cwiseAbs().maxCoeff(), tolerance) << "node " << a;
  }
}

// Reference d: no force from rigid motion in the co-rotational law, the known spurious ones in the
// linear one, for every rotation up to exactly 180 degrees.
TEST(TetElements, RigidMotionCostsNothingWhereElementsRotate) {
  PALPATE_CASE_OR_SKIP(given, "d_solid3d.json", "rigid_rotation");
  const Vector3d shift = solids::VectorOf(given.at("params").at("translation"));
  FemBody rotating = UnitTet(kCorotational), linear = UnitTet(kLinear);
  for (const auto& c : given.at("expected")) {
    const double angle = c.at("degrees").get<double>() * std::numbers::pi / 180;
    const Vector3d axis = solids::VectorOf(c.at("axis")).normalized();
    const Matrix3d R = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    rotating.ForgetRotations();
    EXPECT_LT(ForcesAt(rotating, Deformed(R, shift)).cwiseAbs().maxCoeff(), 1e-12);
    ExpectForces(ForcesAt(linear, Deformed(R, shift)), c.at("linear_fem_spurious_forces"), 1e-12);
  }
}

// Law: if the body rotates rigidly, all its nodes have the same rotation, whatever the sign of the
// quaternions.
TEST(TetElements, NodesTurnWithTheirBody) {
  const SolidMesh mesh = MeshBox({1, 1, 1}, {3, 3, 3});
  FemBody body(mesh, solids::Held(mesh.nodes.size()),
               {.poisson_ratio = 0.25, .law = kCorotational});
  NodeVector u(mesh.nodes.size()), rotations(mesh.nodes.size());
  for (const double angle : {0.0, 0.3, 1.5, 3.1}) {
    const Matrix3d R = Eigen::AngleAxisd(angle, Vector3d(1, -2, 3).normalized()).matrix();
    for (int i = 0; i < body.size(); ++i) {
      const Vector3d& p = body.points()[Index(i)];
      Eigen::Map<Vector3d>(At(u, i).v) = R * p - p;
    }
    body.Evaluate(u);
    body.NodeRotations(rotations);
    for (int i = 0; i < body.moving(); ++i) {
      const double* q = At(rotations, i).v;
      const Matrix3d of_node = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).matrix();
      EXPECT_LT((of_node - R).norm(), 1e-12) << "node " << i << ", " << angle << " rad";
    }
  }
}

// Reference: F = R Q diag(s) Q^T made from rotations, s1 >= s2 >= |s3|: its signed polar rotation
// is R, to the conditioning 1 / (s2 + s3); with it P = R (2 mu (S - I) + lambda tr(S - I) I).
TEST(TetElements, ForcesFollowTheSignedPolarRotationOfAnyMatrix) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto rotation = [&] {
    return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
        .normalized()
        .toRotationMatrix();
  };
  FemBody body = UnitTet(kCorotational);
  const double mu = 0.4, lambda = 0.4;
  int inverted = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Vector3d s(std::abs(normal(random)), std::abs(normal(random)), std::abs(normal(random)));
    std::sort(s.begin(), s.end(), std::greater<>());
    if (trial % 2 == 0) s[2] = -s[2];
    if (s[1] + s[2] < 1e-3) continue;
    inverted += s[2] < 0 ? 1 : 0;
    const Matrix3d R = rotation(), Q = rotation();
    const Matrix3d S = Q * s.asDiagonal() * Q.transpose(), E = S - Matrix3d::Identity();
    const Matrix3d P = R * (2 * mu * E + lambda * E.trace() * Matrix3d::Identity()) / 6;
    const Vector12d forces = ForcesAt(body, Deformed(R * S));
    for (int a = 1; a < 4; ++a) {
      EXPECT_LT((forces.segment<3>(3 * a) - P.col(a - 1)).norm(), 1e-13 / (s[1] + s[2]))
          << "trial " << trial << ", s = " << s.transpose();
    }
  }
  EXPECT_GT(inverted, 500);
}

// Law: the force is the derivative of the energy; central differences with 1e-5 truncate near 1e-9.
TEST(TetElements, TheForceIsTheDerivativeOfTheEnergy) {
  FemBody body = UnitTet(kCorotational, 0.3);
  Matrix3d F;
  F << 0.9, 0.3, -0.2, 0.1, 0.6, 0.25, -0.15, 0.2, 1.3;
  const auto x = Deformed(F);
  const Vector12d f = ForcesAt(body, x);
  const double h = 1e-5;
  const auto energy_at = [&](int d, double step) {
    NodeVector u = DisplacementTo(body, x);
    At(u, body.Number(d / 3)).v[d % 3] += step;
    return body.Evaluate(u).energy;
  };
  for (int d = 0; d < 12; ++d) {
    EXPECT_NEAR((energy_at(d, h) - energy_at(d, -h)) / (2 * h), f[d], 1e-8) << d;
  }
}

}  // namespace
}  // namespace palpate::fem
