#include "slave/vision/texture/stereo_texture.h"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/slave/vision/texture/target_images.h"

namespace palpate {
namespace {

StereoTextureOptions ThreeWindows() {
  StereoTextureOptions options;
  options.at = {{320, 240}, {350, 220}, {290, 260}};
  return options;
}

const Eigen::Vector3d kRest(0, 0, 0);

struct StereoTextureTest : testing::Test {
  TargetImages images;
  StereoTexture texture{images.rig, images.X_SL, ThreeWindows()};
};

// Reference: the drawn surface under the window's centre. The curved surface within a window causes
// 0.2 mm, the cameras' noise less.
TEST_F(StereoTextureTest, PointsLieOnTheSurfaceAndKeepTheirPlaceOnIt) {
  for (int k = 0; k <= 10; ++k) {
    const Eigen::Vector3d p_S(0.0005 * k, -0.0003 * k, 0.0006 * k);
    const auto pair = images.Take(p_S);
    const auto& seen = texture.Process(pair.left, pair.right);
    ASSERT_TRUE(seen.found);
    for (std::size_t i = 0; i < 3; ++i) {
      const SurfacePoint& point = seen.points[i];
      ASSERT_TRUE(point.seen);
      EXPECT_EQ(point.id, static_cast<int>(i));
      const Eigen::Vector3d miss = point.p_S - images.PointOf(ThreeWindows().at[i], kRest, p_S);
      EXPECT_LT(miss.norm(), 0.5e-3);
      EXPECT_LT((point.p_S - point.p_S_rest - p_S).norm(), 0.2e-3);
      // Depth is the least accurate direction: 1.3 mm per pixel, sigma 0.1 px in each image.
      EXPECT_GT(point.covariance(2, 2), point.covariance(0, 0));
      EXPECT_NEAR(std::sqrt(point.covariance(2, 2)), 0.19e-3, 0.06e-3);
    }
  }
}

TEST_F(StereoTextureTest, ATurningBodyIsFollowed) {
  for (int k = 0; k <= 20; ++k) {
    const Eigen::Vector3d turn(0.004 * k, -0.003 * k, 0.01 * k);
    const auto pair = images.Take(kRest, turn);
    const auto& seen = texture.Process(pair.left, pair.right);
    // The target rotates about the ellipsoid's centre, which is one semi-axis z behind S's origin.
    const Eigen::Vector3d centre(0, 0, simulation::TexturedTarget::Shape{}.semi_axes.z());
    const Eigen::Matrix3d R =
        turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                        : Eigen::Matrix3d::Identity();
    for (const SurfacePoint& point : seen.points) {
      ASSERT_TRUE(point.seen) << k;
      EXPECT_LT((point.p_S - centre - R * (point.p_S_rest - centre)).norm(), 0.3e-3) << k;
    }
  }
}

TEST_F(StereoTextureTest, APointLostInOneCameraIsInvisibleUntilRaysMeetAgain) {
  for (int k = 0; k <= 12; ++k) {
    const Eigen::Vector3d p_S(0.001 * k, 0, 0.0005 * k);
    auto pair = images.Take(p_S);
    const bool covered = k >= 4 && k < 8;
    if (covered) pair.right.colRange(0, 640).setTo(60);
    const auto& seen = texture.Process(pair.left, pair.right);
    EXPECT_EQ(seen.found, !covered) << k;
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_EQ(seen.points[i].seen, !covered) << k;
      if (covered) continue;
      EXPECT_LT((seen.points[i].p_S - seen.points[i].p_S_rest - p_S).norm(), 0.2e-3) << k;
    }
  }
}

TEST_F(StereoTextureTest, ImagesThatCannotBeUsedLeaveEverythingUnseen) {
  const auto pair = images.Take(kRest);
  const cv::Mat flat(480, 640, CV_8UC1, cv::Scalar(80));
  EXPECT_FALSE(texture.Process(cv::Mat(), pair.right).found);
  EXPECT_FALSE(texture.Process(flat, flat).found);
  EXPECT_FALSE(texture.Process(pair.left, flat).found);
  EXPECT_FALSE(texture.started());
  EXPECT_TRUE(texture.Process(pair.left, pair.right).found);
  cv::Mat deep;
  pair.left.convertTo(deep, CV_16U, 256);
  for (const cv::Mat& bad : {deep, cv::Mat(pair.left, cv::Rect(0, 0, 320, 240)), cv::Mat()}) {
    const auto& seen = texture.Process(bad, pair.right);
    EXPECT_FALSE(seen.found);
    EXPECT_FALSE(seen.points.front().seen);
    EXPECT_TRUE(seen.points.front().p_S.allFinite());
  }
  EXPECT_TRUE(texture.Process(pair.left, pair.right).found);
}

}  // namespace
}  // namespace palpate
