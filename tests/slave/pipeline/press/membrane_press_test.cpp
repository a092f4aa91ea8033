#include "slave/pipeline/press/membrane_press.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "slave/mechanics/membrane/inflated_membrane.h"
#include "tests/slave/pipeline/press/pressed_dome.h"

namespace palpate {
namespace {

Ellipsoid TestEllipsoid() {
  Ellipsoid ellipsoid;
  ellipsoid.semi_axes = Eigen::Vector3d(0.06, 0.042, 0.047).asDiagonal();
  return ellipsoid;
}

// Points with noise of a pressed membrane, which is finer than the estimator's.
class PressedTruth {
 public:
  PressedTruth(double modulus, double tension)
      : fine_(MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 24),
              {.modulus = modulus, .tension = tension}) {}

  // Returns the points under an even inward pressure within 7 mm of `p_O`.
  std::vector<SurfacePoint> Points(const Eigen::Vector3d& p_O, double force, double sigma) {
    const auto& nodes = fine_.surface().nodes;
    const auto u = DisplacementsUnder({{p_O, force}}, 0.014, fine_);
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

constexpr double kMembraneModulus = 1400, kMembraneTension = 320;

MembranePress TestPress(const MembranePress::Params& params = {}) {
  return {InflatedMembrane(MeshDomedMembrane(TestEllipsoid(), {0, 0, 1}, 0.005, 14),
                           {.modulus = kMembraneModulus, .tension = kMembraneTension}),
          params};
}

// Reference: the scatter of the forces over 60 draws of the noise, with a small model error.
TEST(MembranePress, TheStatedSigmaCoversTheScatter) {
  PressedTruth truth(kMembraneModulus, kMembraneTension);
  MembranePress press = TestPress({.model_error = 1e-6});
  const Eigen::Vector3d p_O = truth.PlaceNear({-0.02, 0.01, 0.04});
  double sum = 0;
  double squares = 0;
  double sigma = 0;
  constexpr int kDraws = 60;
  for (int k = 0; k < kDraws; ++k) {
    const auto& estimate = press.Fit(truth.Points(p_O, 0.05, 50e-6));
    sum += estimate.force / kDraws;
    squares += estimate.force * estimate.force / kDraws;
    sigma += estimate.sigma_force / kDraws;
  }
  const double scatter = std::sqrt(squares - sum * sum);
  EXPECT_LT(scatter, 1.4 * sigma);
  EXPECT_GT(scatter, 0.6 * sigma);
}

TEST(MembranePress, UnusablePointsAreExcludedOrNoLoadIsFound) {
  PressedTruth truth(kMembraneModulus, kMembraneTension);
  MembranePress press = TestPress();
  auto points = truth.Points(truth.PlaceNear({0, 0, 0.047}), 1, 20e-6);
  EXPECT_FALSE(press.Fit({}).found);
  ASSERT_TRUE(press.Fit(points).found);
  const double force = press.Fit(points).force;
  auto bad = points;
  for (auto& point : bad) point.seen = false;
  EXPECT_FALSE(press.Fit(bad).found);
  // A tenth of the points is not finite, another tenth invisible, another without information.
  bad = points;
  for (std::size_t i = 0; i < bad.size(); i += 10) {
    bad[i].p_S.x() = std::numeric_limits<double>::quiet_NaN();
    bad[i + 1 < bad.size() ? i + 1 : i].seen = false;
    if (i + 2 < bad.size()) bad[i + 2].covariance.setConstant(1e300);
  }
  ASSERT_TRUE(press.Fit(bad).found);
  EXPECT_NEAR(press.Fit(bad).force, force, 0.02 * force);
  // The points are far from the membrane.
  for (auto& point : points) point.p_S_rest.z() += 1;
  EXPECT_FALSE(press.Fit(points).found);
}

}  // namespace
}  // namespace palpate
