#include "slave/vision/texture/epipolar_line.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/vision/stereo/test_rigs.h"

namespace palpate {
namespace {

constexpr double kPi = std::numbers::pi;

// Both cameras look the same way, the second one rolled about its axis: the line in its image is
// straight, starting at `infinity` [px] in direction `angle`.
std::vector<Eigen::Vector2d> WalkInImage(const Lens& to, double roll,
                                         const Eigen::Vector2d& infinity, double angle) {
  const Eigen::Matrix3d R_TF = Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).matrix();
  Eigen::Isometry3d X_TF = Eigen::Isometry3d::Identity();
  X_TF.linear() = R_TF;
  X_TF.translation() = 0.06 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  const Lens from = TestLens();
  const Eigen::Vector3d ray_T((infinity.x() - to.cx) / to.fx, (infinity.y() - to.cy) / to.fy, 1);
  EpipolarLine line(from, to, X_TF, *Project(from, R_TF.transpose() * ray_T));
  std::vector<Eigen::Vector2d> places;
  for (int k = 0; k < 10000 && line.Next(1); ++k) {
    if (line.in_image()) places.push_back(*line.place());
  }
  return places;
}

// Reference: the straight line through (480, -10) along (1, 0.5): it enters at x = 499 and leaves
// at y = 69.75. A step is at most 1.5 px. It moves away from the image's centre everywhere.
TEST(EpipolarLineTest, ALineThatCutsACornerIsWalkedThroughTheImage) {
  const auto places = WalkInImage(TestLens(), kPi / 4, {400, -50}, std::atan2(0.5, 1));
  ASSERT_FALSE(places.empty());
  EXPECT_LT((places.front() - Eigen::Vector2d(499, -0.5)).norm(), 1.5);
  EXPECT_LT((places.back() - Eigen::Vector2d(639.5, 69.75)).norm(), 1.5);
  for (const Eigen::Vector2d& p : places) EXPECT_NEAR(p.y() + 10, 0.5 * (p.x() - 480), 1e-9);
}

// Reference: the line sampled every 0.25 px. A section shorter than two steps may be missed.
TEST(EpipolarLineTest, EveryLineThatMeetsTheImageIsFound) {
  const Lens lens = TestLens();
  int met = 0;
  for (int i = 0; i < 24 * 72; ++i) {
    const double around = i / 72 * kPi / 12, angle = i % 72 * kPi / 36 + 0.01;
    const Eigen::Vector2d infinity(320 + 450 * std::cos(around), 240 + 450 * std::sin(around));
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    int inside = 0;
    for (int k = 0; k < 8000; ++k) {
      const Eigen::Vector2d p = infinity + 0.25 * k * along;
      inside += p.minCoeff() >= -0.5 && p.x() <= 639.5 && p.y() <= 479.5 ? 1 : 0;
    }
    const auto places = WalkInImage(lens, 0.3, infinity, angle);
    if (inside == 0) {
      EXPECT_TRUE(places.empty()) << i;
    } else if (inside >= 12) {
      ++met;
      EXPECT_GE(1.5 * static_cast<double>(places.size() + 2), 0.25 * inside) << i;
    }
  }
  EXPECT_GT(met, 400);
}

// Barrel distortion bows lines outwards: near an edge a line may leave the image and enter it
// again.
TEST(EpipolarLineTest, ABowedLineComesBackOverTheEdge) {
  const auto places = WalkInImage(TestLens({-0.27, 0, 0, 0, 0}), 0, {0, -10}, 0);
  ASSERT_FALSE(places.empty());
  EXPECT_GT(places.back().x(), 600);
}

}  // namespace
}  // namespace palpate
