#include "shared/geometry/rotation_between.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

void ExpectTakes(const Vector3d& a, const Vector3d& b) {
  const Eigen::Matrix3d R = RotationBetween(a, b);
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_GT(R.determinant(), 0);
  EXPECT_LT((R * a.stableNormalized() - b.stableNormalized()).norm(), 1e-14);
}

TEST(RotationBetweenTest, TakesOneToTheOther) {
  const Vector3d a(1, 2, 3);
  for (const Vector3d& b :
       {Vector3d(3, -1, 0.5), Vector3d(2, 4, 6), Vector3d(-1, -2, -3), Vector3d(1, 2, 3 + 1e-9),
        Vector3d(-1, -2, -3 + 1e-9), Vector3d(1e-200, 0, 0), Vector3d(0, -1e200, 0)}) {
    ExpectTakes(a, b);
    ExpectTakes(b, a);
  }
}

TEST(RotationBetweenTest, TakesOneToWhatIsOppositeButForRounding) {
  for (int i = 1; i < 1000; ++i) {
    const Vector3d a(std::sin(i), std::cos(2.3 * i), std::sin(4.1 * i));
    ExpectTakes(a, -a * (0.1 + 0.37 * i));
  }
}

TEST(RotationBetweenTest, TurnsNoFartherThanItMust) {
  const Eigen::AngleAxisd turn(RotationBetween({1, 0, 0}, {0, 2, 0}));
  EXPECT_NEAR(turn.angle(), std::numbers::pi / 2, 1e-14);
  EXPECT_NEAR(turn.axis().z(), 1, 1e-14);
}

}  // namespace
}  // namespace palpate
