#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "slave/pipeline/load/plate_limits.h"
#include "slave/pipeline/load/robust_plate_fit.h"

namespace palpate {
namespace {

constexpr double kRadius = 0.039;  // [m]

// A square grid of `across` points a side over the plate and beyond it.
std::vector<SurfacePoint> Grid(int across) {
  std::vector<SurfacePoint> points;
  for (int k = 0; k < across * across; ++k) {
    SurfacePoint point{.id = k, .seen = true};
    point.p_S_rest.head<2>() =
        Eigen::Vector2d(k % across, k / across) * (2.4 * kRadius / (across - 1)) -
        Eigen::Vector2d::Constant(1.2 * kRadius);
    points.push_back(point);
  }
  return points;
}

TEST(EvenChoiceTest, FewPointsAreTakenAsTheyAre) {
  GridSubsample choice(kRadius);
  const auto points = Grid(11);
  const std::vector<int>& chosen = choice.Of(points);
  EXPECT_EQ(static_cast<std::ptrdiff_t>(chosen.size()),
            std::ranges::count_if(points, [](const SurfacePoint& p) {
              return p.p_S_rest.head<2>().norm() <= kRadius;
            }));
}

// Wherever on the plate, there is one within the diagonal of a square, 2 / 11 of the radius wide;
// at the rim, where squares hang over, within two.
TEST(EvenChoiceTest, OfManyThereIsOneEverywhere) {
  GridSubsample choice(kRadius);
  const auto points = Grid(60);
  const std::vector<int>& chosen = choice.Of(points);
  EXPECT_LE(chosen.size(), static_cast<std::size_t>(PlateLimits::kMostPoints));
  EXPECT_GE(chosen.size(), 100U);
  for (const SurfacePoint& point : points) {
    if (point.p_S_rest.head<2>().norm() > kRadius) continue;
    double nearest = 1;
    for (const int i : chosen) {
      ASSERT_NE(i, GridSubsample::kNone);
      const SurfacePoint& other = points[static_cast<std::size_t>(i)];
      EXPECT_LE(other.p_S_rest.head<2>().norm(), kRadius);
      nearest = std::min(nearest, (other.p_S_rest - point.p_S_rest).norm());
    }
    EXPECT_LT(nearest, 2 * std::sqrt(2.0) * 2 * kRadius / 11);
  }
}

TEST(EvenChoiceTest, AHiddenPointsPlaceIsTakenByItsNeighbour) {
  GridSubsample choice(kRadius);
  auto points = Grid(60);
  const std::vector<int> before = choice.Of(points);
  for (const int i : before) points[static_cast<std::size_t>(i)].seen = false;
  const std::vector<int> after = choice.Of(points);
  ASSERT_EQ(before.size(), after.size());
  int taken = 0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_NE(after[k], before[k]);
    if (after[k] == GridSubsample::kNone) continue;
    EXPECT_TRUE(points[static_cast<std::size_t>(after[k])].seen);
    ++taken;
  }
  EXPECT_GE(taken, 95);  // all but squares of one point, at the rim
  for (SurfacePoint& point : points) point.seen = false;
  const std::vector<int>& none = choice.Of(points);
  EXPECT_EQ(none.size(), before.size());
  EXPECT_TRUE(std::ranges::all_of(none, [](int i) { return i == GridSubsample::kNone; }));
}

}  // namespace
}  // namespace palpate
