#include "slave/pipeline/local_model/stiffness_scale.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kFull = 5e-3;  // [m]
constexpr double kLearningRate = 0.3;
constexpr double kSpread = 0.1;

TEST(CompareForcesTest, OnlyFiniteForcesAboveZeroTell) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  EXPECT_TRUE(CompareForces(1, 0, 2).is_informative);
  EXPECT_NEAR(CompareForces(1, 0, 2).ratio, 0.5, 1e-15);
  EXPECT_NEAR(CompareForces(2, 0.1, 2).error, 0.15, 1e-15);
  for (const double bad : {0.0, -1.0, nan, inf}) {
    EXPECT_FALSE(CompareForces(bad, 0, 1).is_informative) << bad;
    EXPECT_FALSE(CompareForces(1, 0, bad).is_informative) << bad;
  }
  EXPECT_FALSE(CompareForces(1, nan, 1).is_informative);
  EXPECT_FALSE(CompareForces(1, inf, 1).is_informative);
  EXPECT_EQ(CompareForces(1e3, 0, 1).ratio, 4);
  EXPECT_EQ(CompareForces(1, 0, 1e3).ratio, 0.25);
}

// Reference: the ratio itself, linear in depth. Of noise of 1 %, a sixth remains after forty
// presses of a hundred samples.
TEST(RatioByDepthTest, LearnsARatioThatChangesWithDepthThroughNoise) {
  StiffnessScale ratio(kFull, kLearningRate, kSpread);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.01);
  const auto truth = [](double depth) { return 1.1 - 0.2 * depth / kFull; };
  for (int press = 0; press < 40; ++press) {
    for (int i = 10; i <= 100; ++i) {
      const double depth = kFull * i / 100;
      ratio.Learn(depth, {truth(depth) + noise(random), 0.03, true});
    }
  }
  for (double depth = 0.2 * kFull; depth <= kFull; depth += 0.1 * kFull) {
    EXPECT_NEAR(ratio.At(depth).ratio, truth(depth), 6e-3) << depth;
  }
  EXPECT_NEAR(ratio.At(0.5 * kFull).slope, -0.2 / kFull, 0.3 * 0.2 / kFull);
}

TEST(RatioByDepthTest, AForceThatDrownsInItsErrorHasNoSay) {
  StiffnessScale ratio(kFull, kLearningRate, kSpread);
  for (int i = 0; i < 5; ++i) ratio.Learn(4e-3, {2, 6, true});
  EXPECT_GT(ratio.At(4e-3).ratio, 1);
  EXPECT_LT(ratio.At(4e-3).ratio, 1.002);  // 5 times the spread's 0.1^2 by 6^2
}

// An estimate at a large depth holds at small depths, too, until one exists there: then each depth
// range keeps its own value.
TEST(RatioByDepthTest, DepthsNotEstimatedFollowTheirNeighbours) {
  StiffnessScale ratio(kFull, kLearningRate, kSpread);
  for (int i = 0; i < 60; ++i) ratio.Learn(kFull, {0.9, 0.01, true});
  EXPECT_NEAR(ratio.At(kFull).ratio, 0.9, 1e-3);
  EXPECT_LT(ratio.At(kFull / 2).ratio, 0.95);
  for (int i = 0; i < 60; ++i) ratio.Learn(0.2 * kFull, {1.1, 0.01, true});
  EXPECT_NEAR(ratio.At(0.2 * kFull).ratio, 1.1, 1e-3);
  EXPECT_NEAR(ratio.At(kFull).ratio, 0.9, 0.02);
}

}  // namespace
}  // namespace palpate
