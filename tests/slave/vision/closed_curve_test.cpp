#include "slave/vision/closed_curve.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace palpate {
namespace {

const Curve kSquare = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
const Curve kEight = {{0, 0}, {4, 4}, {4, 0}, {0, 4}};

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

}  // namespace
}  // namespace palpate
