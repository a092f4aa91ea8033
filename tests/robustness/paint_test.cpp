// The alterations do what their names say: a case that altered nothing would prove nothing.
#include "tests/robustness/paint.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/robustness/case.h"

namespace palpate::robustness {
namespace {

// A picture with fine waves, so that the least motion shows, seen in the middle of a press.
const cv::Mat& Picture() {
  static const cv::Mat drawn = [] {
    cv::Mat picture(480, 640, CV_8U);
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        picture.at<std::uint8_t>(y, x) =
            static_cast<std::uint8_t>(100 + 60 * std::sin(x / 3.0) * std::sin(y / 4.0));
      }
    }
    return picture;
  }();
  return drawn;
}
View Pressed() {
  View view;
  view.script = {4, 10, 20, 30, 40};
  view.index = 28;
  view.tip_I = view.pressed_I = {320, 240};
  view.width = 17;
  return view;
}
cv::Mat Painted(const Paint& paint, const View& view) {
  cv::Mat picture = Picture().clone();
  paint(view, picture);
  return picture;
}
double Difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1);
}

// Of what was painted on Picture(); of another size: all.
double Change(const cv::Mat& painted) {
  return painted.size() == Picture().size() ? Difference(painted, Picture()) : 1;
}

TEST(PaintTest, EveryAlterationOfACasePaintsSomethingAndTheSameAgain) {
  for (const auto& cases : {CameraCases(), PairCases()}) {
    for (const Case& tried : cases) {
      if (!tried.alteration.paint || !tried.is_quick) continue;
      if (!tried.stage.empty()) continue;  // depth: not of 8 bit
      View view = Pressed();
      cv::Mat first = Painted(tried.alteration.paint, view);
      view.side = 1;
      cv::Mat right = Painted(tried.alteration.paint, view);
      EXPECT_GT(Change(first) + Change(right), 0) << tried.title();
      EXPECT_EQ(Difference(right, Painted(tried.alteration.paint, view)), 0) << tried.title();
      EXPECT_EQ(first.type(), CV_8U) << tried.title();
      const bool resized = tried.title().starts_with("of another size");
      EXPECT_EQ(first.size() != Picture().size(), resized) << tried.title();
    }
  }
}

TEST(PaintTest, ABumpOfWholePixelsMovesThePictureWithoutLoss) {
  const cv::Mat moved = Painted(Bump({7, -3}, When::kAtRest), Pressed());
  EXPECT_EQ(Difference(moved(cv::Rect(50, 50, 200, 150)), Picture()(cv::Rect(43, 53, 200, 150))),
            0);
}

TEST(PaintTest, WhatBeginsWhilePressedIsNotThereBefore) {
  View view = Pressed();
  view.index = 12;
  EXPECT_EQ(Difference(Painted(Bump({7, -3}, When::kPressed), view), Picture()), 0);
  EXPECT_GT(Difference(Painted(Bump({7, -3}, When::kAtRest), view), Picture()), 0);
}

// Reference: the standard deviation asked for, in a plain picture. Tolerance: 76800 pixels, and the
// rounding to whole grey levels, which adds 1 / 12 to the variance.
TEST(PaintTest, NoiseHasTheSigmaAskedFor) {
  cv::Mat picture(240, 320, CV_8U, cv::Scalar(128));
  Noise(15)(Pressed(), picture);
  cv::Scalar mean, deviation;
  cv::meanStdDev(picture, mean, deviation);
  EXPECT_NEAR(deviation[0], 15, 0.15);
  EXPECT_NEAR(mean[0], 128, 0.3);
}

TEST(ShowsTest, LateFrozenAndDoubledSamplesAreThoseOfBefore) {
  const Script script{4, 10, 20, 30, 40};
  EXPECT_EQ(Late(5)({script, 28}), 23U);
  EXPECT_EQ(Late(5)({script, 3}), 0U);
  EXPECT_EQ(Late(5, 1)({script, 28, 0}), 28U) << "only the right picture";
  EXPECT_EQ(Frozen(When::kAtRest)({script, 28}), 3U);
  EXPECT_EQ(Frozen(When::kPressed)({script, 28}), 24U);
  EXPECT_EQ(Doubled()({script, 27}), 26U);
}

}  // namespace
}  // namespace palpate::robustness
