// The tool's end as the first image shows it, against where it was drawn.
#include "slave/vision/tool_end.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/slave/vision/test_images.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

// A dark bar with lighter marks that comes from above and ends at `end_I`, before bright ground.
cv::Mat BarEndingAt(const Vector2d& end_I, double width) {
  TestImage image;
  image.size = {120, 160};
  image.tool = PaintedTool{.tip = end_I, .width = width, .level = 30};
  return image.Render();
}

class ToolEndTest : public testing::TestWithParam<double> {};

// Tolerance: a quarter of a pixel, of which marks near the end take the most.
TEST_P(ToolEndTest, IsSeenWhereItIsWhateverIsReported) {
  const Vector2d end(60.3, 90.4), stated = end - Vector2d(0.6 * GetParam(), GetParam());
  const cv::Mat image = BarEndingAt(end, 17);
  const auto seen = DetectToolEnd(image, GreyFormat(image), stated, {0, 1}, 17);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->beyond, GetParam(), 0.25);
  EXPECT_NEAR(seen->aside, -0.6 * GetParam(), 0.25);
  EXPECT_NEAR(seen->width, 17, 0.4);
}
INSTANTIATE_TEST_SUITE_P(ByPixelsReported, ToolEndTest, testing::Values(-4.0, -1.0, 0.0, 0.5, 2.0));

TEST(ToolEnd, OfAWidthReportedWrongByAFifthIsSeen) {
  const Vector2d end(60.3, 90.4);
  const cv::Mat image = BarEndingAt(end, 17);
  const auto seen = DetectToolEnd(image, GreyFormat(image), end, {0, 1}, 0.8 * 17);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->width, 17, 0.4);
}

TEST(ToolEnd, IsNotReportedWhereNoneIsSeen) {
  const cv::Mat image = BarEndingAt({60, 90}, 17);
  const GreyFormat format(image);
  EXPECT_FALSE(DetectToolEnd(image, format, {60, 50}, {0, 1}, 17));  // 40 px before its end
  EXPECT_FALSE(DetectToolEnd(image, format, {20, 90}, {0, 1}, 17));  // ground
  EXPECT_FALSE(
      DetectToolEnd(cv::Mat(160, 120, CV_8U, cv::Scalar(80)), format, {60, 90}, {0, 1}, 17));
}

// A video that begins when the tool has left its home.
TEST(ToolEnd, IsMissedWhereTheToolGoesOn) {
  const cv::Mat image = BarEndingAt({60, 90}, 17);
  const GreyFormat format(image);
  for (const double past : {9.0, 12.0, 20.0, 40.0}) {
    EXPECT_TRUE(ToolGoesOn(image, format, {60, 90 - past}, {0, 1}, 17)) << past;
  }
  for (const double past : {-12.0, -4.0, 0.0, 2.0}) {
    EXPECT_FALSE(ToolGoesOn(image, format, {60, 90 - past}, {0, 1}, 17)) << past;
  }
  EXPECT_FALSE(ToolGoesOn(image, format, {20, 90}, {0, 1}, 17)) << "ground";
}

// The object, as dark as the tool and right under it, is wider.
TEST(ToolEnd, AnObjectUnderItIsNotTheTool) {
  cv::Mat image = BarEndingAt({60, 90}, 17);
  cv::rectangle(image, {10, 92}, {110, 140}, cv::Scalar(30), -1);
  EXPECT_FALSE(ToolGoesOn(image, GreyFormat(image), {60, 90}, {0, 1}, 17));
}

}  // namespace
}  // namespace palpate
