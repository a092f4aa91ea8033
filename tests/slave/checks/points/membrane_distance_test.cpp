#include "slave/checks/points/membrane_distance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slave/checks/points/points_limits.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// A tilted membrane of 50 mm, 200 mm in front of a camera whose axis does not point at it.
class MembraneDistanceTest : public testing::Test {
 protected:
  MembraneDistanceTest() {
    scene_.object.geometry = MembraneGeometry{0.05, 1e-3};
    scene_.object.X_SO = Isometry3d(Eigen::AngleAxisd(0.3, Vector3d::UnitX()));
    X_SE_ = Isometry3d(Eigen::AngleAxisd(0.2, Vector3d::UnitY()));
    X_SE_.translation() = Vector3d(0.03, -0.05, -0.2);
  }
  // Points of the membrane at rest, all at a distance increased by the fraction `farther`; one is
  // not seen.
  [[nodiscard]] SurfaceObservation Seen(double farther) const {
    SurfaceObservation seen;
    seen.found = true;
    for (int i = 0; i < 9; ++i) {
      const Vector3d p_O(0.02 * (i % 3 - 1), 0.02 * (i / 3 - 1), 0);
      SurfacePoint point;
      point.seen = i != 4;
      const Vector3d eye = X_SE_.translation();
      point.p_S_rest = eye + (1 + farther) * (scene_.object.X_SO * p_O - eye);
      if (!point.seen) point.p_S_rest = {0, 0, 1e3};
      seen.points.push_back(point);
    }
    return seen;
  }
  FailedCheck Examine(MembraneDistanceCheck* distance, SurfaceObservation seen) {
    Findings findings;
    distance->Examine({{}, {}, seen}, &findings);
    scale_error_ = seen.scale_error;
    return findings.verdict.check;
  }
  FailedCheck Checked(MembraneDistanceCheck* distance, double farther) {
    return Examine(distance, Seen(farther));
  }

  Scene scene_;
  Isometry3d X_SE_;
  double scale_error_ = 0;
};

TEST_F(MembraneDistanceTest, DepthsThatAreWrongByAShareAreFlagged) {
  for (const double farther : {-0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05}) {
    MembraneDistanceCheck distance(scene_, X_SE_);
    EXPECT_EQ(Checked(&distance, farther), std::abs(farther) > PointsLimits::kTrueSize
                                               ? FailedCheck::kScale
                                               : FailedCheck::kNone)
        << farther;
    EXPECT_NEAR(scale_error_, std::abs(farther), 1e-9);
  }
}

TEST_F(MembraneDistanceTest, TheFirstImageDecidesUntilTheBaselineIsMeasuredAgain) {
  MembraneDistanceCheck distance(scene_, X_SE_);
  EXPECT_EQ(Checked(&distance, 0.05), FailedCheck::kScale);
  EXPECT_EQ(Examine(&distance, SurfaceObservation()), FailedCheck::kNone);
  EXPECT_EQ(Checked(&distance, 0), FailedCheck::kScale);
  distance.Reset();
  EXPECT_EQ(Checked(&distance, 0), FailedCheck::kNone);
}

}  // namespace
}  // namespace palpate
