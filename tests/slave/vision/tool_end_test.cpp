// The tool's end as the first image shows it, against where it was drawn.
#include "slave/vision/tool_end.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/slave/vision/test_images.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

// Draws a dark bar with lighter marks that comes from above and ends at `end_I`, on a bright
// background.
cv::Mat BarEndingAt(const Vector2d& end_I, double width) {
  TestImage image;
  image.size = {120, 160};
  image.tool = PaintedTool{.tip = end_I, .width = width, .level = 30};
  return image.Render();
}

class ToolEndTest : public testing::TestWithParam<double> {};

// Tolerance: a quarter of a pixel, mainly because of marks near the end.
TEST_P(ToolEndTest, IsFoundIndependentOfTheReportedTip) {
  const Vector2d end(60.3, 90.4), stated = end - Vector2d(0.6 * GetParam(), GetParam());
  const cv::Mat image = BarEndingAt(end, 17);
  const auto seen = DetectToolEnd(image, GreyFormat(image), stated, {0, 1}, {17, 0});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->beyond, GetParam(), 0.25);
  EXPECT_NEAR(seen->aside, -0.6 * GetParam(), 0.25);
  EXPECT_NEAR(seen->width, 17, 0.4);
}
INSTANTIATE_TEST_SUITE_P(ByPixelsReported, ToolEndTest, testing::Values(-4.0, -1.0, 0.0, 0.5, 2.0));

TEST(ToolEnd, AWidthWrongByAFifthIsDetected) {
  const Vector2d end(60.3, 90.4);
  const cv::Mat image = BarEndingAt(end, 17);
  const auto seen = DetectToolEnd(image, GreyFormat(image), end, {0, 1}, {0.8 * 17, 0});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->width, 17, 0.4);
}

TEST(ToolEnd, IsNotReportedWhereNoneIsSeen) {
  const cv::Mat image = BarEndingAt({60, 90}, 17);
  const GreyFormat format(image);
  EXPECT_FALSE(DetectToolEnd(image, format, {60, 50}, {0, 1}, {17, 0}));  // 40 px before its end
  EXPECT_FALSE(DetectToolEnd(image, format, {20, 90}, {0, 1}, {17, 0}));  // ground
  EXPECT_FALSE(
      DetectToolEnd(cv::Mat(160, 120, CV_8U, cv::Scalar(80)), format, {60, 90}, {0, 1}, {17, 0}));
}

// A dark bar from above with a round end as wide as itself, by its distance function: `apex` is the
// point of it that is farthest down.
cv::Mat RoundBarEndingAt(const Vector2d& apex, double radius) {
  cv::Mat image(160, 120, CV_8U);
  const Vector2d centre = apex - Vector2d(0, radius);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Vector2d from = Vector2d(x, y) - centre;
      const double beyond = (from.y() < 0 ? std::abs(from.x()) : from.norm()) - radius;
      const double tool = std::clamp(0.5 - beyond, 0.0, 1.0);
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(std::lround(200 - 170 * tool));
    }
  }
  return image;
}

TEST(ToolEnd, ApexIsTheEndOfARoundTool) {
  const Vector2d apex(60.3, 120.4);
  for (const double radius : {10.0, 20.0, 40.0}) {
    const cv::Mat image = RoundBarEndingAt(apex, radius);
    for (const double off : {-2.0, 0.0, 2.0}) {
      const auto seen = DetectToolEnd(image, GreyFormat(image), apex - Vector2d(0, off), {0, 1},
                                      {2 * radius, radius});
      ASSERT_TRUE(seen) << radius << ", " << off;
      EXPECT_NEAR(seen->beyond, off, 0.25) << radius;
      EXPECT_NEAR(seen->aside, 0, 0.25) << radius;
      EXPECT_NEAR(seen->width, 2 * radius, 0.4) << radius;
    }
  }
}

// A video that begins after the tool has left its home.
TEST(ToolEnd, IsNotFoundWhereTheToolContinues) {
  const cv::Mat image = BarEndingAt({60, 90}, 17);
  const GreyFormat format(image);
  for (const double past : {9.0, 12.0, 20.0, 40.0}) {
    EXPECT_TRUE(ToolGoesOn(image, format, {60, 90 - past}, {0, 1}, {17, 0})) << past;
  }
  for (const double past : {-12.0, -4.0, 0.0, 2.0}) {
    EXPECT_FALSE(ToolGoesOn(image, format, {60, 90 - past}, {0, 1}, {17, 0})) << past;
  }
  EXPECT_FALSE(ToolGoesOn(image, format, {20, 90}, {0, 1}, {17, 0})) << "ground";
}

// The object, as dark as the tool and right under it, is wider.
TEST(ToolEnd, AnObjectUnderItIsNotTheTool) {
  cv::Mat image = BarEndingAt({60, 90}, 17);
  cv::rectangle(image, {10, 92}, {110, 140}, cv::Scalar(30), -1);
  EXPECT_FALSE(ToolGoesOn(image, GreyFormat(image), {60, 90}, {0, 1}, {17, 0}));
}

}  // namespace
}  // namespace palpate
