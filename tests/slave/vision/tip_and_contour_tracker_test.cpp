#include "slave/vision/tip_and_contour_tracker.h"

#include <limits>
#include <stdexcept>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slave/vision/closed_curve.h"
#include "slave/vision/observation.h"
#include "tests/slave/vision/test_images.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

TestImage Image() {
  TestImage painting;
  painting.body.emplace();
  painting.tool.emplace();
  painting.tool->tip = {320.3, 150.4};
  return painting;
}

std::string ConstructionMessage(const Scene& scene, const cv::Mat& first,
                                std::optional<Eigen::Vector2d> hint) {
  return Thrown<std::runtime_error>([&] { TipAndContourTracker tracking(scene, first, hint); });
}

TEST(TipAndContourTrackerTest, SeeTipAndContourInImagesOfEveryKind) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
    for (const double full_scale : {65535.0, 4095.0}) {
      TestImage painting = Image();
      TipAndContourTracker tracking(SceneForTestImages(), painting.Render(1, type, full_scale),
                                    painting.tool->tip);
      EXPECT_GT(tracking.rest_contour().edge.size(), 180U);
      painting.tool->tip += Eigen::Vector2d(1.7, 2.6);
      const TipObservation& seen = tracking.Process(painting.Render(2, type, full_scale));
      ASSERT_TRUE(seen.found) << type;
      EXPECT_LT((seen.p_I - painting.tool->tip).norm(), 0.05) << type;
      EXPECT_GT(seen.score, 0.9);
      EXPECT_EQ(tracking.rest_contour().outline.size(), 60U);
      EXPECT_TRUE(tracking.search_window().contains(cv::Point(322, 130)));
    }
  }
}

TEST(TipAndContourTrackerTest, ATemplateFileIsFoundWithoutAHint) {
  const TestImage painting = Image();
  const Scratch scratch;
  const auto file = scratch / "tip.png";
  const cv::Rect window(305, 110, 31, 46);
  ASSERT_TRUE(cv::imwrite(file.string(), painting.Render(5)(window)));
  Scene scene = SceneForTestImages();
  scene.sense.Find<TipTracking>()->template_file = file;
  scene.sense.Find<TipTracking>()->anchor =
      painting.tool->tip - Eigen::Vector2d(window.x, window.y);
  TipAndContourTracker tracking(scene, painting.Render(), std::nullopt);
  const TipObservation& seen = tracking.Process(painting.Render(2));
  ASSERT_TRUE(seen.found);
  EXPECT_TRUE(seen.reacquired);
  EXPECT_LT((seen.p_I - painting.tool->tip).norm(), 0.05);
}

// A bad image of any kind gives no result and no exception, and the next good image is tracked.
TEST(TipAndContourTrackerTest, BadImagesMidStreamAreFlagged) {
  const TestImage painting = Image();
  TipAndContourTracker tracking(SceneForTestImages(), painting.Render(), painting.tool->tip);
  const cv::Mat nan(480, 640, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  cv::Mat noise(480, 640, CV_8UC1);
  cv::randu(noise, 0, 255);
  const std::vector<cv::Mat> bad = {cv::Mat(),
                                    cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)),
                                    cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)),
                                    painting.Render(1, CV_8UC3),
                                    painting.Render(1, CV_16UC1),
                                    nan,
                                    noise,
                                    cv::Mat::zeros(480, 640, CV_8UC1),
                                    cv::Mat(480, 640, CV_8UC1, cv::Scalar(255))};
  std::uint64_t sequence = 0;
  for (const cv::Mat& image : bad) {
    const TipObservation& seen = tracking.Process(image);
    EXPECT_FALSE(seen.found) << sequence;
    EXPECT_TRUE(seen.p_I.allFinite() && std::isfinite(seen.score));
    const TipObservation& good = tracking.Process(painting.Render(++sequence));
    EXPECT_TRUE(good.found) << "after bad image " << sequence;
  }
}

TEST(TipAndContourTrackerTest, ImagesThatCannotBeUsedAreRefusedAtStart) {
  const TestImage painting = Image();
  const Scene scene = SceneForTestImages();
  const Eigen::Vector2d tip = painting.tool->tip;
  EXPECT_EQ(ConstructionMessage(scene, painting.Render(), tip), "");
  EXPECT_THAT(ConstructionMessage(scene, painting.Render(), std::nullopt),
              testing::HasSubstr("sense.tip.template is missing"));
  const std::pair<cv::Mat, const char*> images[] = {
      {cv::Mat(), "empty"},
      {cv::Mat(480, 640, CV_32FC1, cv::Scalar(0)), "CV_32FC1"},
      {cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)), "outside the image"},
      {cv::Mat::zeros(480, 640, CV_8UC1), "no contrast"}};
  for (const auto& [image, words] : images) {
    EXPECT_THAT(ConstructionMessage(scene, image, tip), testing::HasSubstr(words));
  }
}

TEST(TipAndContourTrackerTest, TemplatesThatCannotBeUsedAreRefusedAtStart) {
  const TestImage painting = Image();
  const Scratch scratch;
  cv::Mat wide(40, 700, CV_8UC1);
  cv::randu(wide, 0, 255);
  const std::pair<cv::Mat, const char*> templates[] = {
      {cv::Mat(20, 20, CV_8UC1, cv::Scalar(7)), "tip.png: the template has no contrast"},
      {cv::Mat(2, 2, CV_8UC1, cv::Scalar(7)), "2 x 2 px: expected"},
      {wide, "700 x 40 px"},
      {wide.rowRange(0, 30).colRange(0, 500).t(), "larger than the image"}};
  Scene scene = SceneForTestImages();
  scene.sense.Find<TipTracking>()->template_file = scratch / "tip.png";
  EXPECT_THAT(ConstructionMessage(scene, painting.Render(), painting.tool->tip),
              testing::HasSubstr("tip.png: image"));
  for (const auto& [image, words] : templates) {
    ASSERT_TRUE(cv::imwrite((scratch / "tip.png").string(), image));
    EXPECT_THAT(ConstructionMessage(scene, painting.Render(), painting.tool->tip),
                testing::HasSubstr(words));
  }
}

}  // namespace
}  // namespace palpate
