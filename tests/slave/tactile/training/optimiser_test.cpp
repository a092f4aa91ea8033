#include <gtest/gtest.h>

#include "slave/tactile/training/batch_workers.h"

namespace palpate {
namespace {

using Eigen::VectorXf;

TEST(SgdTest, StepsByRateTimesGradient) {
  VectorXf weights(2);
  weights << 1, -2;
  MakeSgd()->Step(0.5, VectorXf::Constant(2, 4), &weights);
  EXPECT_FLOAT_EQ(weights[0], -1);
  EXPECT_FLOAT_EQ(weights[1], -4);
}

// Law: with both averages raised to what they stand for, the first step is rate * sign(gradient),
// whatever the gradient's size; and under a constant gradient every later one too.
TEST(AdamTest, UnderAConstantGradientEveryStepIsTheRate) {
  VectorXf gradient(3);
  gradient << 1e-3F, -5, 2e4F;
  VectorXf weights = VectorXf::Zero(3);
  const auto adam = MakeAdam(3);
  for (int step = 1; step <= 50; ++step) {
    adam->Step(0.01, gradient, &weights);
    const VectorXf expected = -0.01F * static_cast<float>(step) * gradient.cwiseSign();
    // The floor of 1e-8 beside a gradient of 1e-3 takes 1e-5 away.
    EXPECT_TRUE(weights.isApprox(expected, 1e-4F)) << "step " << step;
  }
}

TEST(AdamTest, FindsTheBottomOfAValleyThatIsAThousandTimesSteeperOneWay) {
  VectorXf weights(2);
  weights << 1, 1;
  const auto adam = MakeAdam(2);
  for (int step = 0; step < 2000; ++step) {
    const VectorXf gradient = Eigen::Vector2f(1000 * weights[0], weights[1]);
    adam->Step(0.01 * (1 - step / 2000.0), gradient, &weights);
  }
  EXPECT_LT(weights.cwiseAbs().maxCoeff(), 1e-3F);
}

}  // namespace
}  // namespace palpate
