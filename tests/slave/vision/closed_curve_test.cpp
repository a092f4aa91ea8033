#include "slave/vision/closed_curve.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace palpate {
namespace {

const Curve kSquare = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
const Curve kEight = {{0, 0}, {4, 4}, {4, 0}, {0, 4}};

TEST(ClosedCurveTest, AreaAndLengthOfASquare) {
  EXPECT_DOUBLE_EQ(CurveArea(kSquare), 16);
  EXPECT_DOUBLE_EQ(CurveArea(Curve(kSquare.rbegin(), kSquare.rend())), -16);
  EXPECT_DOUBLE_EQ(CurveLength(kSquare), 16);
}

TEST(ClosedCurveTest, CrossingsAreFound) {
  EXPECT_FALSE(CrossesItself(kSquare));
  EXPECT_TRUE(CrossesItself(kEight));
  const Curve notched = {{0, 0}, {9, 0}, {9, 9}, {4, 1}, {0, 9}};
  EXPECT_FALSE(CrossesItself(notched));
  const Curve through = {{0, 0}, {9, 0}, {9, 9}, {4, -1}, {0, 9}};
  EXPECT_TRUE(CrossesItself(through));
}

// Reference: points at equal arc length on a polygon lie on it; on a circle of many corners their
// distances are equal chords.
TEST(ClosedCurveTest, ResampledPointsAreEquallySpaced) {
  Curve circle;
  for (int k = 0; k < 720; ++k) {
    const double angle = k * std::numbers::pi / 360;
    circle.emplace_back(50 * std::cos(angle), 50 * std::sin(angle));
  }
  for (const int count : {3, 60, 1000}) {
    const Curve even = Resample(circle, count);
    ASSERT_EQ(even.size(), static_cast<std::size_t>(count));
    const double chord = 2 * 50 * std::sin(std::numbers::pi / count);
    for (std::size_t i = 0; i < even.size(); ++i) {
      EXPECT_NEAR((even[(i + 1) % even.size()] - even[i]).norm(), chord, 1e-3 * chord + 1e-3) << i;
    }
  }
  EXPECT_EQ(Resample(kSquare, 4), kSquare);
}

// Reference: a circle of 100 px with alternating jitter of 2 px; the mean over a spacing leaves
// less than half of one point's jitter. Its radius shrinks by the sagitta of the averaged arc,
// below 0.1 px.
TEST(ClosedCurve, SmoothingAveragesTheJitterOut) {
  Curve jittery;
  for (int i = 0; i < 240; ++i) {
    const double angle = 2 * std::numbers::pi * i / 240, r = 100 + (i % 2 != 0 ? 2 : -2);
    jittery.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  const Curve smooth = Smoothed(jittery, 60);
  ASSERT_EQ(smooth.size(), 60U);
  for (const Eigen::Vector2d& p : smooth) EXPECT_NEAR(p.norm(), 100, 1.0);
}

}  // namespace
}  // namespace palpate
