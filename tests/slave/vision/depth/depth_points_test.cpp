#include "slave/vision/depth/depth_points.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/vision/depth/depth_images.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Surface = std::function<double(double, double)>;

// Enough to spread the rounding to 0.1 mm evenly: together one sigma of 0.058 mm.
constexpr DepthNoise kDither{0.05e-3, 1};

// Points of a plane n . p = d.
Surface FlatSurface(const Eigen::Vector3d& n, double d) {
  return [=](double x, double y) { return d / n.dot(Eigen::Vector3d(x, y, 1)); };
}
DepthPoints::Params TestParams() {
  DepthPoints::Params params;
  params.camera = TestDepthCamera();
  params.rest_images = 4;
  return params;
}

class DepthPointsTest : public ::testing::Test {
 protected:
  cv::Mat Image(const Surface& surface, DepthNoise noise = {}) {
    return DepthImage(TestDepthCamera(), surface, noise, &random_);
  }
  void TakeRest(DepthPoints* cameras, const Surface& surface, DepthNoise noise = {}) {
    for (int k = 0; k < 4; ++k) {
      EXPECT_FALSE(cameras->Observe(Image(surface, noise)).found);
    }
    EXPECT_TRUE(cameras->at_rest_known());
  }
  std::mt19937 random_{7};
};

// Reference: the plane: every rest point lies on it, and every normal equals its normal. Tolerance:
// the mean over four images of 256 pixels has a sigma of 2 um, the slope over a cell of 6 mm one of
// 1e-3; each times five.
TEST_F(DepthPointsTest, PointsAtRestLieOnTheirPlaneWithItsNormal) {
  auto params = TestParams();
  params.camera.X_SD = Eigen::Translation3d(0.1, -0.2, 0.3) *
                       Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -0.5).normalized());
  DepthPoints cameras(params);
  const Eigen::Vector3d n = Eigen::Vector3d(0.5, -0.3, 1).normalized();
  TakeRest(&cameras, FlatSurface(n, 0.11), kDither);
  const auto& seen = cameras.Observe(Image(FlatSurface(n, 0.11)));
  ASSERT_TRUE(seen.found);
  ASSERT_EQ(seen.points.size(), 20U * 15U);
  const Eigen::Vector3d n_S = params.camera.X_SD.linear() * n;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    const Eigen::Vector3d p_D = params.camera.X_SD.inverse() * seen.points[i].p_S_rest;
    EXPECT_NEAR(n.dot(p_D), 0.11, 10e-6) << i;
    EXPECT_LT((cameras.normal_S(i) + n_S).norm(), 5e-3) << i;
    // The point must lie at the centre of its cell.
    EXPECT_NEAR(p_D.x() / p_D.z() * params.camera.fx + params.camera.cx, cameras.place(i).x(),
                1e-9);
    EXPECT_NEAR(p_D.y() / p_D.z() * params.camera.fy + params.camera.cy, cameras.place(i).y(),
                1e-9);
    EXPECT_EQ(seen.points[i].id, static_cast<int>(i));
  }
}

// Reference: the same plane, with a quarter of every cell's pixels lost on one side at rest and on
// the other side now: the visible part of the slanted surface differs, its position does not.
// Tolerance: five sigma of a mean over the 128 pixels in common.
TEST_F(DepthPointsTest, HolesOnASlantDoNotMoveThePoint) {
  DepthPoints cameras(TestParams());
  const Eigen::Vector3d n = Eigen::Vector3d(-0.8, 0, 1).normalized();
  const auto with_hole = [&](bool left, double s) {
    cv::Mat image = Image(FlatSurface(n, 0.11 + s), kDither);
    for (int u = 0; u < image.cols; ++u) {
      if (left ? u % 16 < 4 : u % 16 >= 12) image.col(u).setTo(0);
    }
    return image;
  };
  for (int k = 0; k < 4; ++k) cameras.Observe(with_hole(true, 0));
  const auto& seen = cameras.Observe(with_hole(false, 0.001));
  ASSERT_TRUE(seen.found);
  for (const SurfacePoint& point : seen.points) {
    EXPECT_NEAR(n.dot(point.p_S - point.p_S_rest), 0.001, 30e-6) << point.id;
  }
}

// Reference: the noise that was put in: patches of 8 x 8 pixels have a common error of 0.08 mm. The
// stated sigma is that of the scatter in a cell of four such patches, or up to a half larger: the
// spread of four values is as often too large as too small, and the larger of it and the stated
// sigma is used. With independent pixels it is within a tenth.
TEST_F(DepthPointsTest, TheStatedSigmaIsThatOfTheScatter) {
  const auto scatter = [this](int patch) {
    auto params = TestParams();
    params.correlation = patch;
    DepthPoints cameras(params);
    const DepthNoise noise{params.camera.sigma, patch};
    const Surface plane = FlatSurface({0, 0, 1}, 0.1);
    TakeRest(&cameras, plane, noise);
    double squares = 0;
    int count = 0;
    for (int k = 0; k < 20; ++k) {
      const auto& seen = cameras.Observe(Image(plane, noise));
      for (std::size_t i = 0; i < seen.points.size(); ++i) {
        const SurfacePoint& point = seen.points[i];
        const Eigen::Vector3d& n = cameras.normal_S(i);
        const double off = n.dot(point.p_S - point.p_S_rest);
        squares += off * off / n.dot(point.covariance * n);
        ++count;
      }
    }
    return std::sqrt(squares / count);
  };
  EXPECT_NEAR(scatter(1), 1, 0.1);
  EXPECT_GT(scatter(8), 0.67);
  EXPECT_LT(scatter(8), 1.05);
}

// Reference: 30 % of the pixels lost and 10 % thrown by 20 mm, both at random: the mean over the
// cell stays within five sigma of a mean over clean pixels, 0.08 mm / sqrt(150), and of the rest's.
TEST_F(DepthPointsTest, OutliersAndHolesDoNotShiftTheMean) {
  DepthPoints cameras(TestParams());
  const Surface plane = FlatSurface(Eigen::Vector3d(0.3, 0, 1).normalized(), 0.1);
  TakeRest(&cameras, plane, kDither);
  cv::Mat image = Image(plane, {0.08e-3, 1});
  std::uniform_real_distribution<double> uniform;
  for (auto it = image.begin<std::uint16_t>(); it != image.end<std::uint16_t>(); ++it) {
    const double dice = uniform(random_);
    if (dice < 0.3) *it = 0;
    if (dice > 0.9) *it = static_cast<std::uint16_t>(*it + 200);
  }
  const auto& seen = cameras.Observe(image);
  for (const SurfacePoint& point : seen.points) {
    ASSERT_TRUE(point.seen);
    EXPECT_LT((point.p_S - point.p_S_rest).norm(), 40e-6) << point.id;
  }
}

TEST_F(DepthPointsTest, ImagesThatCannotBeUsedAreNoObservation) {
  DepthPoints cameras(TestParams());
  const Surface plane = FlatSurface({0, 0, 1}, 0.1);
  const cv::Mat empty, zeros(240, 320, CV_16UC1, cv::Scalar(0)), bytes(240, 320, CV_8UC1),
      wide(240, 400, CV_16UC1, cv::Scalar(1000)), saturated(240, 320, CV_16UC1, cv::Scalar(65535));
  for (const cv::Mat* bad : {&empty, &zeros, &bytes, &saturated}) {
    EXPECT_FALSE(cameras.Observe(*bad).found);
    EXPECT_FALSE(cameras.at_rest_known());
  }
  TakeRest(&cameras, plane);
  for (const cv::Mat* bad : {&empty, &zeros, &bytes, &wide, &saturated}) {
    const auto& seen = cameras.Observe(*bad);
    EXPECT_FALSE(seen.found);
    EXPECT_THAT(seen.points, ::testing::Each(::testing::Field(&SurfacePoint::seen, false)));
    EXPECT_TRUE(cameras.Observe(Image(plane)).found);
  }
  cameras.Reset();
  EXPECT_FALSE(cameras.Observe(wide).found);
  EXPECT_FALSE(cameras.at_rest_known());
  EXPECT_TRUE(cameras.Observe(wide).points.empty());
}

TEST_F(DepthPointsTest, ObservingAllocatesNothingOnceTheRestIsKnown) {
  DepthPoints cameras(TestParams());
  const Surface plane = FlatSurface({0, 0, 1}, 0.1);
  TakeRest(&cameras, plane);
  const cv::Mat image = Image(FlatSurface({0, 0, 1}, 0.101), {0.08e-3, 8});
  const long before = AllocationCount();
  for (int k = 0; k < 20; ++k) cameras.Observe(image);
  EXPECT_EQ(AllocationCount(), before);
}

}  // namespace
}  // namespace palpate
