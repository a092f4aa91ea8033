#include <gtest/gtest.h>

#include "master/haptics/force_chain.h"

namespace palpate {
namespace {

using Target = OutputBlend::Target;

Eigen::Vector3d Step(OutputBlend* blend, const Eigen::Vector3d& rendered, double dt) {
  return blend->Send(blend->Wanted(rendered, dt), dt);
}

const Eigen::Vector3d kForce(0, 2, 0);

// Reference: a straight line in time.
TEST(OutputBlendTest, ComesInStraightAndThenFollowsExactly) {
  OutputBlend blend;
  blend.Go(Target::kRendered, 0.050);
  for (int i = 1; i <= 50; ++i) EXPECT_NEAR(Step(&blend, kForce, 0.001).y(), 2 * i / 50.0, 1e-9);
  EXPECT_EQ(Step(&blend, -kForce, 0.001), -kForce);
  EXPECT_FALSE(blend.is_blending());
}

// The slave's stop or an open clutch occurs while HOLD fades the force.
TEST(OutputBlendTest, AFadeThatIsRequestedAgainEndsNoLater) {
  OutputBlend blend;
  const Eigen::Vector3d rendered(0, 2, 0);
  blend.Go(Target::kRendered, 0);
  Step(&blend, rendered, 0.001);
  blend.Go(Target::kZero, 0.040);
  for (int i = 0; i < 39; ++i) {
    if (i == 20) blend.Go(Target::kZero, 0.040);
    Step(&blend, rendered, 0.001);
  }
  EXPECT_GT(blend.Send(blend.Wanted(rendered, 0), 0.001).norm(), 0);
  EXPECT_LT(Step(&blend, rendered, 0.0011).norm(), 1e-15);
}

// Reference: 200 N/s is 0.2 N per millisecond, up and down; a longer tick allows no larger change.
TEST(OutputBlendTest, ChangesNoFasterThanItsSlewBothWays) {
  OutputBlend blend(200);
  blend.Go(Target::kRendered, 0);
  EXPECT_NEAR(Step(&blend, kForce, 0.001).y(), 0.2, 1e-12);
  EXPECT_TRUE(blend.is_slewed());
  EXPECT_NEAR(Step(&blend, -kForce, 0.020).y(), 0.0, 1e-12);
  EXPECT_NEAR(Step(&blend, -kForce, 0.001).y(), -0.2, 1e-12);
  EXPECT_NEAR(Step(&blend, {0, -0.3, 0}, 0.001).y(), -0.3, 1e-12);
  EXPECT_FALSE(blend.is_slewed());
}

TEST(OutputBlendTest, ANewTransitionBeginsAtThePresentForce) {
  OutputBlend blend;
  blend.Go(Target::kRendered, 0.050);
  for (int i = 0; i < 25; ++i) Step(&blend, kForce, 0.001);
  blend.Go(Target::kZero, 0.050);
  EXPECT_NEAR(Step(&blend, kForce, 0.001).y(), 1 - 1 / 50.0, 1e-9);
}

}  // namespace
}  // namespace palpate
