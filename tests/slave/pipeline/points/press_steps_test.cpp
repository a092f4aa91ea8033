#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slave/pipeline/points/points_scores.h"

namespace palpate {
namespace {

// A ramp between halts of 0, 1 and 2 mm, and back to 1 mm.
PressSteps PressedSteps() {
  PressSteps steps;
  const auto halt = [&](double depth, double truth, std::initializer_list<double> stated) {
    for (const double force : stated) {
      steps.Add(Eigen::Vector3d(0, 0, 1e-5 * force));
      steps.Add(depth, truth, force);
    }
  };
  halt(0, 0, {0.1, 0.0, 0.2});
  halt(0.4e-3, 0.5, {0.5});  // during the motion
  halt(1e-3, 1, {0.9, 1.2, 1.05});
  halt(2e-3, 3, {3.0, 3.0, 3.3});
  halt(1e-3, 1, {1.0, 1.0, 1.0});
  return steps;
}

TEST(PressStepsTest, PairsAtOneDepthAreAStepOfTheApproach) {
  const std::vector<PressStep> steps = PressedSteps().steps();
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[1].depth, 1e-3);
  EXPECT_EQ(steps[1].pairs, 3);
  EXPECT_NEAR(steps[1].force, 1.05, 1e-12);
  EXPECT_NEAR(steps[1].force_error, 0.2, 1e-12);
  EXPECT_NEAR(steps[2].displacement.peak(), 3.3e-5, 1e-12);
  EXPECT_EQ(steps[2].displacement.count(), 3U);
}

}  // namespace
}  // namespace palpate
