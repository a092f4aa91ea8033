#include "slave/mechanics/membrane/inflated_membrane.h"

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Forces = std::vector<Eigen::Vector3d>;

Forces PressureOn(const InflatedMembrane& membrane, double pressure) {
  Forces forces;
  for (std::size_t i = 0; i < membrane.areas().size(); ++i) {
    forces.push_back(pressure * membrane.areas()[i] * membrane.normals()[i]);
  }
  return forces;
}

Ellipsoid Sphere(double radius) {
  Ellipsoid sphere;
  sphere.semi_axes *= radius;
  return sphere;
}

// Reference: T lap w = -q on a disc, w = q (a^2 - r^2) / (4 T). Linear triangles on the polygon err
// by (h / a)^2 with h = a / 24, some 2e-3; there is no modulus and no curvature, so only the
// tension holds it.
TEST(InflatedMembrane, AFlatDiscUnderTensionBulgesAsAParabola) {
  const double a = 0.04;
  const double T = 120;
  const double q = 35;
  const InflatedMembrane membrane(MeshFlatMembrane(a, 24), {.tension = T});
  EXPECT_NEAR(membrane.pressure(), 0, 1e-9);
  Forces u;
  membrane.Displace(PressureOn(membrane, q), &u);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double r = membrane.surface().nodes[i].norm();
    EXPECT_NEAR(u[i].z(), q * (a * a - r * r) / (4 * T), 4e-3 * q * a * a / (4 * T)) << r / a;
    EXPECT_NEAR(u[i].head<2>().norm(), 0, 1e-12);
  }
}

// Reference: Laplace's law, p = 2 T / R.
TEST(InflatedMembrane, TheBalancingPressureOfASphereIsLaplaces) {
  const double R = 0.05;
  const InflatedMembrane membrane(MeshDomedMembrane(Sphere(R), {0, 0, 1}, 0.01, 16),
                                  {.modulus = 1500, .tension = 90});
  EXPECT_NEAR(membrane.pressure(), 2 * 90 / R, 0.01 * 2 * 90 / R);
}

// Reference: equilibrium of a sphere that grows by u: 2 E h u / ((1 - nu) R^2) of the skin, less 2
// T u / R^2 because the tension balances less pressure at the larger radius (3 % of the first term
// with T = E h / 20). It is compared at the equator of a bowl whose rim is far below: the rim's
// effect decays over R sqrt(T / (2 E h)) = R / 6, and the bowl as a whole may shift along its axis.
// Tolerance: flat triangles of R / 20 lie inside the sphere.
TEST(InflatedMembrane, ASphereUnderMorePressureGrowsByTheSkinsOwnStiffness) {
  const double R = 0.05;
  const double nu = 0.4;
  for (const double T : {4.0, 100.0}) {
    const double Eh = 2000;
    const InflatedMembrane membrane(MeshDomedMembrane(Sphere(R), {0, 0, 1}, -0.9 * R, 60),
                                    {.modulus = Eh, .poisson_ratio = nu, .tension = T});
    Forces u;
    membrane.Displace(PressureOn(membrane, 100), &u);
    double mean = 0;
    int count = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      const Eigen::Vector3d& p = membrane.surface().nodes[i];
      if (std::abs(p.z()) > 0.05 * R) continue;
      mean += u[i].head<2>().dot(p.head<2>().normalized());
      ++count;
    }
    mean /= count;
    EXPECT_NEAR(mean / (100 * R * R / (2 * Eh / (1 - nu) - 2 * T)), 1, 0.01) << T;
  }
}

// Reference: reciprocity, and the displacements themselves.
TEST(InflatedMembrane, TheComplianceIsSymmetricAndThatOfTheDisplacements) {
  const InflatedMembrane membrane(
      MeshDomedMembrane(Sphere(0.05), Eigen::Vector3d(0.6, 0, 0.8), 0.01, 6),
      {.modulus = 1500, .tension = 300, .air_stiffness = 2e8});
  const auto C = membrane.NormalCompliance();
  EXPECT_LT((C - C.transpose()).norm(), 1e-12 * C.norm());
  Forces forces(membrane.surface().nodes.size(), Eigen::Vector3d::Zero());
  forces[11] = 2 * membrane.normals()[11];
  Forces u;
  membrane.Displace(forces, &u);
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR(u[i].dot(membrane.normals()[i]), 2 * C(static_cast<int>(i), 11), 1e-12);
  }
}

// Reference: the gas law of a small volume: volume that is displaced at one place bulges elsewhere,
// and the pressure rises by k times the missing volume.
TEST(InflatedMembrane, AirThatHardlyGivesKeepsItsVolume) {
  for (const double k : {1e8, 1e13}) {
    const InflatedMembrane membrane(MeshDomedMembrane(Sphere(0.05), {0, 0, 1}, 0.01, 12),
                                    {.modulus = 1500, .tension = 300, .air_stiffness = k});
    Forces forces(membrane.surface().nodes.size(), Eigen::Vector3d::Zero());
    forces[3] = -membrane.normals()[3];
    Forces u;
    const double rise = membrane.Displace(forces, &u);
    double volume = 0;
    double moved = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      volume += membrane.areas()[i] * membrane.normals()[i].dot(u[i]);
      moved += membrane.areas()[i] * std::abs(membrane.normals()[i].dot(u[i]));
    }
    EXPECT_GT(rise, 0);
    if (k == 1e13) {
      EXPECT_LT(std::abs(volume), 1e-4 * moved);
    } else {
      EXPECT_NEAR(rise, -k * volume, 1e-9 * rise);
    }
  }
}

// Reference: itself on finer meshes. Linear triangles converge with the square of their size: each
// time the size is halved, the compliance under a load over a fixed patch changes by a quarter of
// the previous change or less.
TEST(InflatedMembrane, GiveUnderALoadConvergesWithTheSquareOfTheMesh) {
  const auto give = [](int rings) {
    const InflatedMembrane membrane(MeshDomedMembrane(Sphere(0.05), {0, 0, 1}, 0.01, rings),
                                    {.modulus = 1500, .tension = 300});
    // A pressure that falls off smoothly around the top.
    Forces forces = PressureOn(membrane, -100);
    for (std::size_t i = 0; i < forces.size(); ++i) {
      const double r = membrane.surface().nodes[i].head<2>().norm() / 0.02;
      forces[i] *= std::exp(-r * r);
    }
    Forces u;
    membrane.Displace(forces, &u);
    return -u[0].z();
  };
  const double coarse = give(8);
  const double middle = give(16);
  const double fine = give(32);
  EXPECT_LT(std::abs(fine - middle), 0.35 * std::abs(middle - coarse));
  EXPECT_LT(std::abs(fine - middle), 0.01 * fine);
}

TEST(InflatedMembrane, WhatCannotBeComputedIsRefusedWithItsReason) {
  const auto refusal =
      [](const std::function<void(MembraneShape*, InflatedMembrane::Params*)>& change) {
        MembraneShape shape = MeshFlatMembrane(0.04, 3);
        InflatedMembrane::Params params{.modulus = 1000, .tension = 100};
        change(&shape, &params);
        return Thrown<std::invalid_argument>(
            [&] { const InflatedMembrane membrane(std::move(shape), params); });
      };
  using S = MembraneShape*;
  using P = InflatedMembrane::Params*;
  using ::testing::HasSubstr;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal([](S, P) {}), "");
  EXPECT_THAT(refusal([](S, P p) { p->modulus = -1; }), HasSubstr("modulus = -1"));
  EXPECT_THAT(refusal([](S, P p) { p->modulus = p->tension = 0; }), HasSubstr("modulus = 0"));
  EXPECT_THAT(refusal([&](S, P p) { p->tension = nan; }), HasSubstr("tension = "));
  EXPECT_THAT(refusal([](S, P p) { p->poisson_ratio = 0.6; }), HasSubstr("poisson_ratio = 0.6"));
  EXPECT_THAT(refusal([](S, P p) { p->air_stiffness = -2; }), HasSubstr("air_stiffness = -2"));
  EXPECT_THAT(refusal([&](S, P p) { p->pressure = nan; }), HasSubstr("pressure = "));
  EXPECT_THAT(refusal([](S s, P) { s->surface.triangles.clear(); }), HasSubstr("no triangle"));
  EXPECT_THAT(refusal([&](S s, P) { s->surface.nodes[2].x() = nan; }), HasSubstr("node 2"));
  EXPECT_THAT(refusal([](S s, P) { s->surface.triangles[4][1] = 999; }), HasSubstr("triangle 4"));
  EXPECT_THAT(refusal([](S s, P) { s->surface.triangles[4][1] = s->surface.triangles[4][0]; }),
              HasSubstr("triangle 4 has no area"));
  EXPECT_THAT(refusal([](S s, P) { s->held.push_back(-1); }), HasSubstr("fixed node -1"));
  EXPECT_THAT(refusal([](S s, P) { s->surface.nodes.emplace_back(1, 0, 0); }),
              HasSubstr("belongs to no triangle"));
  // Without supports, or with a flat skin without tension, there is no stiffness along the normal.
  EXPECT_THAT(refusal([](S s, P) { s->held.clear(); }), HasSubstr("unstable"));
  EXPECT_THAT(refusal([](S, P p) { p->tension = 0; }), HasSubstr("unstable"));
}

}  // namespace
}  // namespace palpate
