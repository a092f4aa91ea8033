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
#include "tests/slave/vision/test_pictures.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

TestPicture Picture() {
  TestPicture picture;
  picture.body.emplace();
  picture.tool.emplace();
  picture.tool->tip = {320.3, 150.4};
  return picture;
}

std::string ConstructionMessage(const Scene& scene, const cv::Mat& first,
                                std::optional<Eigen::Vector2d> hint) {
  return Thrown<std::runtime_error>([&] { TipAndContourTracker tracking(scene, first, hint); });
}

TEST(TipAndContourTrackerTest, SeeTipAndContourInPicturesOfEveryKind) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
    for (const double full_scale : {65535.0, 4095.0}) {
      TestPicture picture = Picture();
      TipAndContourTracker tracking(SceneForTestPictures(), picture.Render(1, type, full_scale),
                                    picture.tool->tip);
      EXPECT_GT(tracking.rest_contour().edge.size(), 180U);
      picture.tool->tip += Eigen::Vector2d(1.7, 2.6);
      const TipObservation& seen = tracking.Process(picture.Render(2, type, full_scale));
      ASSERT_TRUE(seen.found) << type;
      EXPECT_LT((seen.p_I - picture.tool->tip).norm(), 0.05) << type;
      EXPECT_GT(seen.score, 0.9);
      EXPECT_EQ(tracking.rest_contour().outline.size(), 60U);
      EXPECT_TRUE(tracking.search_window().contains(cv::Point(322, 130)));
    }
  }
}

TEST(TipAndContourTrackerTest, ATemplateFileIsFoundWithoutAHint) {
  const TestPicture picture = Picture();
  const Scratch scratch;
  const auto file = scratch / "tip.png";
  const cv::Rect window(305, 110, 31, 46);
  ASSERT_TRUE(cv::imwrite(file.string(), picture.Render(5)(window)));
  Scene scene = SceneForTestPictures();
  scene.sense.Find<TipTracking>()->template_file = file;
  scene.sense.Find<TipTracking>()->anchor = picture.tool->tip - Eigen::Vector2d(window.x, window.y);
  TipAndContourTracker tracking(scene, picture.Render(), std::nullopt);
  const TipObservation& seen = tracking.Process(picture.Render(2));
  ASSERT_TRUE(seen.found);
  EXPECT_TRUE(seen.reacquired);
  EXPECT_LT((seen.p_I - picture.tool->tip).norm(), 0.05);
}

// Whatever comes mid-stream: nothing found, nothing thrown, and the next good picture is seen.
TEST(TipAndContourTrackerTest, BadPicturesMidStreamAreFlagged) {
  const TestPicture picture = Picture();
  TipAndContourTracker tracking(SceneForTestPictures(), picture.Render(), picture.tool->tip);
  const cv::Mat nan(480, 640, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  cv::Mat noise(480, 640, CV_8UC1);
  cv::randu(noise, 0, 255);
  const std::vector<cv::Mat> bad = {cv::Mat(),
                                    cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)),
                                    cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)),
                                    picture.Render(1, CV_8UC3),
                                    picture.Render(1, CV_16UC1),
                                    nan,
                                    noise,
                                    cv::Mat::zeros(480, 640, CV_8UC1),
                                    cv::Mat(480, 640, CV_8UC1, cv::Scalar(255))};
  std::uint64_t sequence = 0;
  for (const cv::Mat& image : bad) {
    const TipObservation& seen = tracking.Process(image);
    EXPECT_FALSE(seen.found) << sequence;
    EXPECT_TRUE(seen.p_I.allFinite() && std::isfinite(seen.score));
    const TipObservation& good = tracking.Process(picture.Render(++sequence));
    EXPECT_TRUE(good.found) << "after bad picture " << sequence;
  }
}

TEST(TipAndContourTrackerTest, ImagesThatCannotBeUsedAreRefusedAtStart) {
  const TestPicture picture = Picture();
  const Scene scene = SceneForTestPictures();
  const Eigen::Vector2d tip = picture.tool->tip;
  EXPECT_EQ(ConstructionMessage(scene, picture.Render(), tip), "");
  EXPECT_THAT(ConstructionMessage(scene, picture.Render(), std::nullopt),
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
  const TestPicture picture = Picture();
  const Scratch scratch;
  cv::Mat wide(40, 700, CV_8UC1);
  cv::randu(wide, 0, 255);
  const std::pair<cv::Mat, const char*> templates[] = {
      {cv::Mat(20, 20, CV_8UC1, cv::Scalar(7)), "tip.png: the template has no contrast"},
      {cv::Mat(2, 2, CV_8UC1, cv::Scalar(7)), "2 x 2 px: expected"},
      {wide, "700 x 40 px"},
      {wide.rowRange(0, 30).colRange(0, 500).t(), "larger than the image"}};
  Scene scene = SceneForTestPictures();
  scene.sense.Find<TipTracking>()->template_file = scratch / "tip.png";
  EXPECT_THAT(ConstructionMessage(scene, picture.Render(), picture.tool->tip),
              testing::HasSubstr("tip.png: image"));
  for (const auto& [image, words] : templates) {
    ASSERT_TRUE(cv::imwrite((scratch / "tip.png").string(), image));
    EXPECT_THAT(ConstructionMessage(scene, picture.Render(), picture.tool->tip),
                testing::HasSubstr(words));
  }
}

}  // namespace
}  // namespace palpate
