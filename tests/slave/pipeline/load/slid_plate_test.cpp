// Cameras that were bumped: all points have slid together, and stay so from then on.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/pipeline/load/robust_plate_fit.h"
#include "tests/slave/pipeline/points/membrane_scene.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing_fakes::kModulus;
using testing_fakes::kNu;
using testing_fakes::kRadius;
using testing_fakes::kThickness;
using testing_fakes::kToolWidth;

constexpr double kPlateLoad = -20, kPlateSigma = 2e-5;  // [N], [m]
const Vector3d kSlide(1.2e-3, -0.6e-3, 0.05e-3);

class SlidPlateTest : public testing::Test {
 protected:
  std::vector<SurfacePoint> Points(bool slid, double force = kPlateLoad) {
    SurfaceObservation seen =
        testing_fakes::DotsUnder(truth_, {0.012, 0.004}, force, kPlateSigma, &random_);
    for (SurfacePoint& point : seen.points) point.p_S += slid ? kSlide : Vector3d::Zero();
    return seen.points;
  }
  // Scatter of the force in 40 images, slid [N], rms.
  double ScatterOfForce() {
    double square = 0;
    for (int k = 0; k < 40; ++k) {
      const PlateFit answer = fit_.Fit(Points(true));
      EXPECT_TRUE(answer.compensated) << k;
      EXPECT_NEAR(answer.load.rim_motion[0], kSlide.z(), 2 * kPlateSigma) << k;
      square += std::pow(answer.load.force - kPlateLoad, 2);
    }
    return std::sqrt(square / 40);
  }
  void ExpectForceOfTenImages(bool slid) {
    for (int k = 0; k < 10; ++k) {
      const PlateFit answer = fit_.Fit(Points(slid));
      EXPECT_NEAR(answer.load.force, kPlateLoad, 0.03 * std::abs(kPlateLoad)) << k;
      EXPECT_EQ(answer.moved, slid) << k;
      EXPECT_EQ(answer.compensated, slid) << k;
    }
  }

  PlateLargeModel truth_{{kRadius, kThickness, kModulus, kNu}};
  PlateLargeModel plate_{{kRadius, kThickness, kModulus, kNu}};
  RobustPlateFit fit_{plate_, {kToolWidth}};
  std::mt19937 random_{5};
};

TEST_F(SlidPlateTest, AMembraneThatSlidBackIsFoundAtRest) {
  for (const bool slid : {true, false, true, false}) ExpectForceOfTenImages(slid);
}

// A rim with an unknown position absorbs a part of the load's shape; a rim that was seen at rest
// does not.
TEST_F(SlidPlateTest, ARimMotionIsMeasuredWithoutContact) {
  const double unknown = ScatterOfForce();
  fit_.Reset();
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(fit_.Fit(Points(true, 0)).load.nothing) << k;
  EXPECT_LT(ScatterOfForce(), 0.7 * unknown);
}

// A model whose rim keeps its old position would explain the rim's motion by a force.
TEST_F(SlidPlateTest, ARimThatMovesAgainIsNotHeldWhereItWas) {
  for (int k = 0; k < 20; ++k) fit_.Fit(Points(true, 0));
  for (int k = 0; k < 5; ++k) {
    std::vector<SurfacePoint> points = Points(true);
    for (SurfacePoint& point : points) point.p_S.z() += 0.2e-3;
    const PlateFit answer = fit_.Fit(points);
    EXPECT_NEAR(answer.load.force, kPlateLoad, 0.03 * std::abs(kPlateLoad)) << k;
    EXPECT_NEAR(answer.load.rim_motion[0], kSlide.z() + 0.2e-3, 2 * kPlateSigma) << k;
  }
}

}  // namespace
}  // namespace palpate
