#include "slave/vision/interlace_detector.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector2d;

const Vector2d kMiddle(80, 60);

// A bright disc with an edge two pixels wide; odd rows `aside` to the left.
cv::Mat Disc(int aside, double noise) {
  std::mt19937 random(3);
  std::normal_distribution<double> grain(0, 1);
  cv::Mat picture(120, 160, CV_8U);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const double from = (Vector2d(x + (y % 2 == 1 ? aside : 0), y) - kMiddle).norm() - 35;
      const double level = 60 + 120 / (1 + std::exp(from)) + noise * grain(random);
      picture.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(level);
    }
  }
  return picture;
}

TEST(InterlaceDetectorTest, RowsThatLieAsideAreToldWithTheirShift) {
  for (const double noise : {0.0, 2.0}) {
    for (const int aside : {-6, -3, 2, 4, 7}) {
      const cv::Mat picture = Disc(aside, noise);
      InterlaceDetector comb(picture);
      EXPECT_EQ(comb.Shift(picture, kMiddle), -aside) << noise;
      EXPECT_EQ(comb.Shift(picture, kMiddle + Vector2d(0, 9)), -aside) << noise;
    }
  }
}

TEST(InterlaceDetectorTest, APictureAsItShouldBeHasNone) {
  for (const double noise : {0.0, 2.0, 15.0}) {
    const cv::Mat picture = Disc(0, noise);
    InterlaceDetector comb(picture);
    for (const double x : {0.0, 40.0, 80.0, 159.0}) {
      EXPECT_EQ(comb.Shift(picture, {x, 60}), 0);
    }
  }
  const cv::Mat plain(120, 160, CV_8U, cv::Scalar(90));
  EXPECT_EQ(InterlaceDetector(plain).Shift(plain, kMiddle), 0);
}

// A raw picture of a colour sensor, on something plain and grey: one row moved by any odd number of
// pixels looks like the next, and only noise tells them apart.
TEST(InterlaceDetectorTest, AMosaicOfColoursIsNoComb) {
  std::mt19937 random(5);
  std::normal_distribution<double> grain(0, 2);
  for (int drawn = 0; drawn < 8; ++drawn) {
    cv::Mat picture(120, 160, CV_8U);
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        const double colour = y % 2 != x % 2 ? 150 : y % 2 == 0 ? 80 : 90;
        picture.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(colour + grain(random));
      }
    }
    EXPECT_LE(std::abs(InterlaceDetector(picture).Shift(picture, kMiddle)), 1) << drawn;
  }
}

TEST(InterlaceDetectorTest, WhatIsNotInThePictureTellsNothing) {
  const cv::Mat picture = Disc(4, 0), other(60, 80, CV_8U, cv::Scalar(0));
  InterlaceDetector comb(picture);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const Vector2d& p : {Vector2d(-500, 0), Vector2d(1e300, 1e300), Vector2d(kNone, 0)}) {
    EXPECT_EQ(comb.Shift(picture, p), 0);
  }
  EXPECT_EQ(comb.Shift(other, kMiddle), 0);
  EXPECT_EQ(comb.Shift({}, kMiddle), 0);
}

}  // namespace
}  // namespace palpate
