#include <cmath>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/pipeline/points/surface_estimator.h"
#include "tests/slave/pipeline/points/estimated_membrane.h"
#include "tests/slave/pipeline/points/membrane_scene.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using namespace testing_fakes;

// Reference: the model itself, pressed to that depth. The table behind it is good to 0.2 %.
TEST(SurfaceContactTest, TheLocalContactIsTangentToTheMembranesForce) {
  Scene scene = MembraneScene("plate-large");
  scene.object.X_SO = Askew();
  SurfaceEstimator estimator(scene);
  PlateLargeModel model({kRadius, kThickness, kModulus, kNu});
  const Vector3d n_S = scene.object.X_SO.linear().col(2);
  for (const double r : {0.002, 0.0117, 0.02, 0.028}) {
    for (const double depth : {1e-4, 7e-4, 2.3e-3, 5e-3}) {
      const Vector3d p_O(r * std::cos(1.0), r * std::sin(1.0), 0);
      Contact contact{.p_O = p_O, .width = kToolWidth, .prescribed_O = {0, 0, -depth}};
      ContactResponse response;
      model.Respond(std::span(&contact, 1), std::span(&response, 1));
      const Vector3d p_S_tip = scene.object.X_SO * Vector3d(p_O - depth * Vector3d::UnitZ());
      const LocalModel local = estimator.LocalAt(p_S_tip);
      EXPECT_TRUE(local.in_contact);
      EXPECT_NEAR((local.normal - n_S).norm(), 0, 1e-12);
      const Vector3d force = local.force + local.stiffness * (local.reference - p_S_tip);
      EXPECT_NEAR(force.dot(n_S) / -response.force_O.z(), 1, 4e-3) << r << " " << depth;
      EXPECT_NEAR(n_S.dot(local.stiffness * n_S) / response.stiffness_O(2, 2), 1, 1.5e-2)
          << r << " " << depth;
      EXPECT_GT(local.Penetration(p_S_tip), 0);
    }
  }
  // Above it: the surface at rest, with the stiffness of first touch.
  const LocalModel above = estimator.LocalAt(scene.object.X_SO * Vector3d(0.01, 0, 0.002));
  EXPECT_FALSE(above.in_contact);
  EXPECT_NEAR((above.reference - scene.object.X_SO * Vector3d(0.01, 0, 0)).norm(), 0, 1e-12);
  const LocalModel touch = estimator.LocalAt(scene.object.X_SO * Vector3d(0.01, 0, -1e-6));
  EXPECT_NEAR(above.stiffness.norm() / touch.stiffness.norm(), 1, 1e-3);
}

TEST(SurfaceContactTest, TheLocalContactIsUsableAnywhereAndKeepsTheLastForNonsense) {
  SurfaceEstimator& estimator = Large();
  for (const Vector3d& tip : {Vector3d(0.0385, 0, -0.001), Vector3d(0.2, 0.3, -0.05),
                              Vector3d(0, 0, -1e3), Vector3d(1e300, 0, 0), Vector3d(0, 0, 1e300)}) {
    const LocalModel local = estimator.LocalAt(tip);
    EXPECT_TRUE(local.reference.allFinite() && local.stiffness.allFinite()) << tip.transpose();
    EXPECT_GE(local.stiffness.trace(), 0);
  }
  const LocalModel last = estimator.LocalAt({0.01, 0, 0});
  const LocalModel kept = estimator.LocalAt({std::nan(""), 0, 0});
  EXPECT_EQ(kept.revision, last.revision);
  EXPECT_EQ(kept.reference, last.reference);
}

// A scene whose cameras have a rate: 30 Hz.
Scene WatchedScene() {
  Scene scene = MembraneScene("plate-large");
  scene.sense.Set(PointsOptions{StereoCameras{.rate = 30}, {}});
  return scene;
}

// The tip is pressed in beside the membrane's centre, and the real membrane is softer there than
// the model.
class RenderedMembraneTest : public ::testing::Test {
 protected:
  static constexpr double kSofter = 0.9;
  static SurfaceEstimator& estimator() {
    static SurfaceEstimator estimator(WatchedScene());
    return estimator;
  }
  RenderedMembraneTest() { estimator().Reset(); }
  static Vector3d TipAt(double depth) { return {0.005, 0.002, -depth}; }
  static double Modelled(double depth) { return estimator().body().PressAt(TipAt(0), depth).force; }
  static double Rendered(double depth) {
    const LocalModel local = estimator().LocalAt(TipAt(depth));
    return (local.force + local.stiffness * (local.reference - TipAt(depth))).z();
  }
  // Returns the dots under `share` times the model's force at that depth.
  SurfaceObservation Dots(double depth, double share, double sigma = kSigma) {
    return DotsUnder(FinerPlate(), TipAt(0).head<2>(), -share * Modelled(depth), sigma, &random_);
  }
  void Hold(double depth, double share, int images) {
    for (int i = 0; i < images; ++i) estimator().Estimate(Dots(depth, share), TipAt(depth));
  }
  std::mt19937 random_{12};
};

// Reference: the mean force estimated from the dots, which differs from the load by up to 1.5 %
// because the number of modes is limited.
TEST_F(RenderedMembraneTest, TheRenderedForceBecomesTheOneEstimated) {
  constexpr int kImages = 60;
  double mean = 0;
  for (int i = 0; i < kImages; ++i) {
    Hold(4e-3, kSofter, 1);
    mean += estimator().estimate().force->z() / kImages;
  }
  EXPECT_NEAR(Rendered(4e-3) / mean, 1, 5e-3);
  EXPECT_NEAR(Rendered(4e-3) / Modelled(4e-3), kSofter, 0.02);
  const double h = 1e-5;
  const double slope = (Rendered(4.2e-3 + h) - Rendered(4.2e-3 - h)) / (2 * h);
  EXPECT_NEAR(estimator().LocalAt(TipAt(4.2e-3)).stiffness.trace() / slope, 1, 5e-3);
}

// Reference: each image changes the ratio at most by the learning rate, 1 - exp(-1 / 3), times the
// difference of a tenth: 2.8 % of the force. The error of the fit adds at most half a percent.
TEST_F(RenderedMembraneTest, TheRenderedForceNeverJumps) {
  estimator().Estimate(Dots(4e-3, kSofter), TipAt(4e-3));
  double last = Rendered(4e-3);
  double largest = std::abs(last / Modelled(4e-3) - 1);
  for (int i = 0; i < 30; ++i) {
    const std::uint64_t revision = estimator().LocalAt(TipAt(4e-3)).revision;
    Hold(4e-3, kSofter, 1);
    EXPECT_GT(estimator().LocalAt(TipAt(4e-3)).revision, revision);  // which the master blends
    largest = std::max(largest, std::abs(Rendered(4e-3) / last - 1));
    last = Rendered(4e-3);
  }
  EXPECT_LT(largest, 0.035);
}

// A moved rim, a press by another tool beside the tip, a tip above the membrane, a grazing tip, and
// lost points.
TEST_F(RenderedMembraneTest, FlaggedAndForeignLoadsAreNotLearnt) {
  const double modelled = Rendered(4e-3);
  SurfaceObservation lost = Dots(4e-3, kSofter), raised = lost;
  lost.found = false;
  for (SurfacePoint& point : raised.points) point.p_S.z() -= 4e-4;
  for (int i = 0; i < 5; ++i) {
    EXPECT_NE(estimator().Estimate(raised, TipAt(4e-3)).validity, Validity::kValid);
  }
  EXPECT_EQ(Rendered(4e-3), modelled);
  for (const Vector3d& tip : {Vector3d(-0.02, 0, -4e-3), TipAt(-1e-3), TipAt(4e-4)}) {
    for (int i = 0; i < 5; ++i) {
      ASSERT_EQ(estimator().Estimate(Dots(4e-3, kSofter), tip).validity, Validity::kValid);
    }
    EXPECT_EQ(Rendered(4e-3), modelled) << tip.transpose();
  }
  for (int i = 0; i < 5; ++i) estimator().Estimate(lost, TipAt(4e-3));
  EXPECT_EQ(Rendered(4e-3), modelled);
}

// The image is older than the tip, so during the indentation the estimated force belongs to a
// smaller depth. At 20 mm/s and a whole period, 0.67 mm, the ratio would fall to 0.7.
TEST_F(RenderedMembraneTest, AMovingTipHasLittleWeightInLearning) {
  constexpr double kStep = 0.02 / 30;
  for (int press = 0; press < 3; ++press) {
    for (double depth = kStep; depth < 4.5e-3; depth += kStep) {
      const double share = Modelled(depth - kStep) / Modelled(depth);
      estimator().Estimate(Dots(depth, share), TipAt(depth));
    }
    estimator().Estimate(DotsUnder(FinerPlate(), {0, 0}, 0, kSigma, &random_), kAway);
  }
  EXPECT_NEAR(Rendered(4e-3) / Modelled(4e-3), 1, 0.05);
  Hold(4e-3, 1, 30);
  EXPECT_NEAR(Rendered(4e-3) / Modelled(4e-3), 1, 0.02);
}

}  // namespace
}  // namespace palpate
