#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 1e-4, kNoise = 1e-5, kTolerance = 5e-4;  // [m]

Vector3d TipAt(int image) {
  return {0, -kStep * image, 0};
}

// Returns the tip as seen by displaced cameras whose images are `late` image periods late.
Vector3d SeenAt(int image, int late) {
  return Vector3d(2e-3, 1e-3, 0) + TipAt(image - late);
}

TEST(ArmConsistencyCheckTest, ConsistentCamerasAndArmDoNotPartForAnyCameraPosition) {
  ArmConsistencyCheck watch;
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(watch.Agree(SeenAt(i, 0), {TipAt(i), 0.45}, kTolerance));
    EXPECT_EQ(watch.PartingBeyond(kNoise), Vector3d(0, 0, 0));
  }
}

// A difference that is small enough to be accepted still shows as a step while the tip moves.
TEST(ArmConsistencyCheckTest, ALagOfOneImageShowsAsAStepAlthoughBothAgree) {
  ArmConsistencyCheck watch;
  EXPECT_TRUE(watch.Agree(SeenAt(0, 0), {TipAt(0), 0.45}, kTolerance));
  for (int i = 1; i < 20; ++i) {
    EXPECT_TRUE(watch.Agree(SeenAt(i, 1), {TipAt(i), 0.45}, kTolerance));
    const Vector3d parting = watch.PartingBeyond(kNoise);
    EXPECT_GT(parting.y(), 0.75 * kStep) << i;
    EXPECT_LT(parting.y(), kStep) << i;
    EXPECT_NEAR(parting.x(), 0, 1e-12);
  }
}

}  // namespace
}  // namespace palpate
