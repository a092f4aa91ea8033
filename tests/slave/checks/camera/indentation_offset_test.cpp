#include "slave/checks/camera/indentation_offset.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kModel = 0.075, kEdge = 0.2, kImage = 0.1;  // sigmas: [-], [px], [px]

// A press to 14 px in steps of a third of a pixel; the edge shows (1 + f) depth - offset, and no
// indentation before contact.
IndentationOffset FitPress(double f, double offset, double deepest, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, kImage);
  IndentationOffset fit;
  for (double depth = 0.2; depth < deepest; depth += 1.0 / 3) {
    const double shown = std::max(0.0, (1 + f) * depth - offset) + noise(random);
    fit.Add({.depth = depth, .shown = shown, .sigma = kImage}, kModel, kEdge);
  }
  return fit;
}

TEST(IndentationOffset, NothingIsKnownBeforeTheFirstImage) {
  const IndentationOffset fit;
  EXPECT_EQ(fit.value(), 0);
  EXPECT_TRUE(std::isinf(fit.sigma()));
}

// Reference: the offset in the data. Tolerance: 3 sigma.
TEST(IndentationOffset, IsTheExcessOfDepthOverIndentation) {
  for (const double offset : {-3.0, -1.0, 0.0, 1.0, 3.0}) {
    const IndentationOffset fit = FitPress(0, offset, 14, 1);
    EXPECT_NEAR(fit.value(), offset, 3 * fit.sigma()) << offset;
    EXPECT_LT(fit.sigma(), 0.3);
  }
}

// A steeper indentation within the model's error is not reported as an offset: none of 200 presses
// at 3.5 sigma, where chance gives one of 2000.
TEST(IndentationOffset, ASteeperIndentationIsNoOffset) {
  std::mt19937 random(7);
  std::normal_distribution<double> model(0, kModel);
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const IndentationOffset fit = FitPress(model(random), 0, 14, seed);
    EXPECT_LT(std::abs(fit.value()), 3.5 * fit.sigma()) << seed;
  }
}

// Two pixels are found within five pixels of depth.
TEST(IndentationOffset, IsFoundWhileThePressBegins) {
  for (const double offset : {-2.0, 2.0}) {
    const IndentationOffset fit = FitPress(0.05, offset, 5, 3);
    EXPECT_GT(std::abs(fit.value()), 3.5 * fit.sigma()) << offset;
  }
}

// Many images of the same depth have the weight of one.
TEST(IndentationOffset, RepeatedImagesDoNotAddUp) {
  IndentationOffset once, often;
  once.Add({5.5, 5.9, kImage}, kModel, kEdge);
  for (int k = 0; k < 1000; ++k) often.Add({5.5, 5.9, kImage}, kModel, kEdge);
  EXPECT_LT(often.sigma(), once.sigma());
  EXPECT_GT(often.sigma(), std::hypot(kEdge, kModel * 5.5) * 0.999);
}

TEST(IndentationOffset, IsForgottenOnReset) {
  IndentationOffset fit = FitPress(0, 3, 14, 1);
  fit.Reset();
  EXPECT_EQ(fit.value(), 0);
}

}  // namespace
}  // namespace palpate
