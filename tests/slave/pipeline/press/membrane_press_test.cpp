#include "slave/pipeline/press/membrane_press.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slave/mechanics/membrane/inflated_membrane.h"
#include "tests/slave/pipeline/press/identify_membrane.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

Ellipsoid TestEllipsoid() {
  Ellipsoid ellipsoid;
  ellipsoid.semi_axes = Eigen::Vector3d(0.06, 0.042, 0.047).asDiagonal();
  return ellipsoid;
}

// A finer membrane than the one that estimates, pressed, and points of it with noise.
class PressedTruth {
 public:
  PressedTruth(double modulus, double tension)
      : fine_(MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 24),
              {.modulus = modulus, .tension = tension}) {}

  // Inward, an even pressure within 7 mm of `p_O`; the air's pressure rises too.
  std::vector<SurfacePoint> Points(const Eigen::Vector3d& p_O, double force, double pressure_rise,
                                   double sigma) {
    const auto& nodes = fine_.surface().nodes;
    std::vector<Eigen::Vector3d> f(nodes.size(), Eigen::Vector3d::Zero());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const double inside = std::clamp(0.5 + (7e-3 - (nodes[i] - p_O).norm()) / 2e-3, 0.0, 1.0);
      f[i] = -inside * fine_.areas()[i] * fine_.normals()[i];
      sum += f[i];
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      f[i] = f[i] * (force / sum.norm()) + pressure_rise * fine_.areas()[i] * fine_.normals()[i];
    }
    std::vector<Eigen::Vector3d> u;
    fine_.Displace(f, &u);
    std::normal_distribution<double> normal(0, sigma);
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < nodes.size(); i += 2) {
      if (fine_.IsHeld(static_cast<int>(i))) continue;
      SurfacePoint point;
      point.id = static_cast<int>(i);
      point.seen = true;
      point.p_S_rest = nodes[i];
      point.p_S = nodes[i] + u[i] + normal(random_) * fine_.normals()[i];
      point.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
      points.push_back(point);
    }
    return points;
  }
  [[nodiscard]] const Eigen::Vector3d& PlaceNear(const Eigen::Vector3d& p) const {
    const auto& nodes = fine_.surface().nodes;
    return *std::min_element(nodes.begin(), nodes.end(), [&](const auto& a, const auto& b) {
      return (a - p).norm() < (b - p).norm();
    });
  }

 private:
  InflatedMembrane fine_;
  std::mt19937 random_{5};
};

constexpr double kModulus = 1400, kTension = 320;

MembranePress TestPress(double modulus = kModulus, double tension = kTension) {
  return {InflatedMembrane(MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 14),
                           {.modulus = modulus, .tension = tension}),
          {}};
}

// Reference: the force and place that pressed a membrane of three times as many triangles.
// Tolerance: its triangles of 5 mm follow a patch of 14 mm to 3 %; the place to a tenth of them.
TEST(MembranePress, ForceAndPlaceComeBackAnywhereOnTheDome) {
  PressedTruth truth(kModulus, kTension);
  MembranePress press = TestPress();
  for (const Eigen::Vector3d& at :
       {Eigen::Vector3d(0, 0, 0.047), Eigen::Vector3d(-0.03, 0.01, 0.04),
        Eigen::Vector3d(0.02, -0.025, 0.03)}) {
    const Eigen::Vector3d p_O = truth.PlaceNear(at);
    for (const double force : {0.3, 4.0}) {
      for (const double rise : {0.0, 300.0}) {
        const auto& reading = press.Fit(truth.Points(p_O, force, rise, 20e-6));
        ASSERT_TRUE(reading.found);
        EXPECT_NEAR(reading.Force(1, rise), force, 0.03 * force + 4 * reading.sigma_own_force)
            << p_O.transpose() << ", " << rise << " Pa";
        EXPECT_LT((reading.p_O - p_O).norm(), 0.6e-3 + 4 * reading.sigma_place);
        EXPECT_GT(reading.n_O.dot(p_O.normalized()), 0.9);
        EXPECT_NEAR(reading.own_pressure, rise, 0.03 * (rise + 100 * force) + 5);
      }
    }
  }
}

// Reference: linearity. Of a membrane s times as stiff the same press moves s times less, and the
// force is found again with that s.
TEST(MembranePress, StiffnessMultipliesTheForceAndNotTheAirs) {
  PressedTruth stiff(2.5 * kModulus, 2.5 * kTension);
  MembranePress press = TestPress();
  const auto& reading = press.Fit(stiff.Points(stiff.PlaceNear({-0.02, 0.01, 0.04}), 3, 400, 5e-6));
  EXPECT_NEAR(reading.Force(2.5, 400), 3, 0.09);
  EXPECT_GT(std::abs(reading.air_area * 400), 0.3);
}

// Reference: 200 draws of the noise. The stated sigma is that of the scatter; the model's own
// error, which every point is allowed, makes it larger: sqrt(20^2 + 100^2) um for a scatter by 20.
TEST(MembranePress, TheStatedSigmaCoversTheScatter) {
  PressedTruth truth(kModulus, kTension);
  MembranePress::Params params;
  params.model_error = 1e-6;
  MembranePress press(InflatedMembrane(MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 14),
                                       {.modulus = kModulus, .tension = kTension}),
                      params);
  const Eigen::Vector3d p_O = truth.PlaceNear({-0.02, 0.01, 0.04});
  double sum = 0;
  double squares = 0;
  double sigma = 0;
  constexpr int kDraws = 60;
  for (int k = 0; k < kDraws; ++k) {
    const auto& reading = press.Fit(truth.Points(p_O, 0.05, 0, 50e-6));
    sum += reading.own_force / kDraws;
    squares += reading.own_force * reading.own_force / kDraws;
    sigma += reading.sigma_own_force / kDraws;
  }
  const double scatter = std::sqrt(squares - sum * sum);
  EXPECT_LT(scatter, 1.4 * sigma);
  EXPECT_GT(scatter, 0.6 * sigma);
}

// Reference: the truth's own numbers. The share of the tension comes from the shape alone (within
// a tenth: triangles of 5 mm blur the dent), the stiffness from the forces.
TEST(MembranePress, WhatTheMembraneIsMadeOfIsFoundFromKnownPresses) {
  PressedTruth truth(kModulus, kTension);
  std::vector<PressSample> samples;
  for (const double force : {0.0, 0.5, 1.0, 1.8}) {
    const double rise = 60 * force;
    samples.push_back({truth.Points(truth.PlaceNear({-0.02, 0.01, 0.04}), force, rise, 20e-6), rise,
                       force + 0.2});
  }
  const auto identified = IdentifyMembrane(MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 14),
                                           0.5, {}, samples, true);
  EXPECT_EQ(identified.in_contact, 3);
  EXPECT_NEAR(identified.tension_share / (kTension / kModulus), 1, 0.15);
  EXPECT_NEAR(identified.params.tension / kTension, 1, 0.1);
  EXPECT_NEAR(identified.fit.offset, 0.2, 0.02);
  EXPECT_THROW(IdentifyMembrane(MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 6), 0.5, {},
                                std::vector<PressSample>(5, samples[0]), false),
               std::invalid_argument);
}

// Reference: the air behind. Pressed at constant volume, without a measured pressure, the model's
// own air explains the bulge, and the force comes back.
TEST(MembranePress, EnclosedAirNeedsNoPressureSensor) {
  const double k = 3e8;
  const auto shape = MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 14);
  const InflatedMembrane::Params params{
      .modulus = kModulus, .tension = kTension, .air_stiffness = k};
  const InflatedMembrane membrane(shape, params);
  // Its own patch at a node, so that nothing but the air is on trial. The place is found to a
  // twentieth of a triangle, which tells in the depth by half a percent.
  const PatchCompliance patch(membrane, 0.014, false);
  const int node = 100;
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < shape.surface.nodes.size(); ++i) {
    SurfacePoint point;
    point.id = static_cast<int>(i);
    point.seen = true;
    point.p_S_rest = shape.surface.nodes[i];
    point.p_S =
        point.p_S_rest + 2.0 * patch.by_patch()(static_cast<int>(i), node) * membrane.normals()[i];
    points.push_back(point);
  }
  MembranePress press(InflatedMembrane(shape, params), {.pressure_is_measured = false});
  const auto& reading = press.Fit(points);
  EXPECT_NEAR(reading.Force(1, 1e6), 2, 1e-3);
  EXPECT_NEAR(reading.depth, 2 * patch.GiveAt({node, node, node}, {1, 0, 0}), 5e-6);
  EXPECT_LT((reading.p_O - shape.surface.nodes[node]).norm(), 0.1e-3);
}

TEST(MembranePress, WhatCannotBeReadIsNotFound) {
  PressedTruth truth(kModulus, kTension);
  MembranePress press = TestPress();
  auto points = truth.Points(truth.PlaceNear({0, 0, 0.047}), 1, 0, 20e-6);
  EXPECT_FALSE(press.Fit({}).found);
  ASSERT_TRUE(press.Fit(points).found);
  const double force = press.reading().own_force;
  auto bad = points;
  for (auto& point : bad) point.seen = false;
  EXPECT_FALSE(press.Fit(bad).found);
  // A tenth of nonsense is left out, another tenth unseen.
  bad = points;
  for (std::size_t i = 0; i < bad.size(); i += 10) {
    bad[i].p_S.x() = std::numeric_limits<double>::quiet_NaN();
    bad[i + 1 < bad.size() ? i + 1 : i].seen = false;
    if (i + 2 < bad.size()) bad[i + 2].covariance.setConstant(1e300);
  }
  ASSERT_TRUE(press.Fit(bad).found);
  EXPECT_NEAR(press.reading().own_force, force, 0.02 * force);
  // Nowhere near the membrane.
  for (auto& point : points) point.p_S_rest.z() += 1;
  EXPECT_FALSE(press.Fit(points).found);
}

// Reference: a line through known points, and its scatter about them.
TEST(StiffnessFit, IsTheLineThroughTheForces) {
  const std::vector<KnownPress> presses{{1, 0.1, 2.6}, {2, 0.2, 4.7}, {3, 0.3, 6.8}};
  const auto fit = FitStiffness(presses, true);
  EXPECT_NEAR(fit.stiffness, 2, 1e-12);
  EXPECT_NEAR(fit.offset, 0.5, 1e-12);
  EXPECT_NEAR(fit.scatter, 0, 1e-12);
  const auto through_zero = FitStiffness(presses, false);
  EXPECT_EQ(through_zero.offset, 0);
  EXPECT_NEAR(through_zero.stiffness, (2.5 + 2 * 4.5 + 3 * 6.5) / 14, 1e-12);
  EXPECT_GT(through_zero.sigma_stiffness, 0);
  EXPECT_THROW(FitStiffness(std::vector<KnownPress>(1), false), std::invalid_argument);
  EXPECT_THROW(FitStiffness(std::vector<KnownPress>(3), false), std::invalid_argument);
  EXPECT_THROW(FitStiffness(std::vector<KnownPress>(4, {1, 0, 2}), true), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
