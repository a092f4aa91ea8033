#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kArmStep = 1e-4, kArmNoise = 1e-5, kArmTolerance = 5e-4;  // [m]

Vector3d ArmTipAt(int image) {
  return {0, -kArmStep * image, 0};
}

// Returns the tip as seen by displaced cameras whose images are `late` image periods late.
Vector3d SeenAt(int image, int late) {
  return Vector3d(2e-3, 1e-3, 0) + ArmTipAt(image - late);
}

TEST(ArmConsistencyCheckTest, ConsistentCamerasAndArmDoNotPartForAnyCameraPosition) {
  ArmConsistencyCheck watch;
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(watch.Agree(SeenAt(i, 0), {ArmTipAt(i), 0.45}, kArmTolerance));
    EXPECT_EQ(watch.PartingBeyond(kArmNoise), Vector3d(0, 0, 0));
  }
}

// A difference that is small enough to be accepted still shows as a step while the tip moves.
TEST(ArmConsistencyCheckTest, ALagOfOneImageShowsAsAStepAlthoughBothAgree) {
  ArmConsistencyCheck watch;
  EXPECT_TRUE(watch.Agree(SeenAt(0, 0), {ArmTipAt(0), 0.45}, kArmTolerance));
  for (int i = 1; i < 20; ++i) {
    EXPECT_TRUE(watch.Agree(SeenAt(i, 1), {ArmTipAt(i), 0.45}, kArmTolerance));
    const Vector3d parting = watch.PartingBeyond(kArmNoise);
    EXPECT_GT(parting.y(), 0.75 * kArmStep) << i;
    EXPECT_LT(parting.y(), kArmStep) << i;
    EXPECT_NEAR(parting.x(), 0, 1e-12);
  }
}

}  // namespace
}  // namespace palpate
