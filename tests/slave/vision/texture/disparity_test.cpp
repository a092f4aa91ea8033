// Real rectified pairs with true disparities, and what a search along rows must refuse.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/vision/texture/row_matcher.h"
#include "tests/slave/vision/texture/texture_pictures.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

const std::filesystem::path kFolder = SourcePath("/../shared/data/stereo_disparity");

struct RealPair {
  std::string left, right, truth;
  double scale;             // levels of `truth` per pixel of disparity
  int most;                 // disparity searched [px]
  double median, outliers;  // required
};

class RealPairTest : public testing::TestWithParam<RealPair> {};

// Reference: the set's true disparities (whole pixels for aloe: 0.25 px of the median is theirs).
// Selection: up to 2000 corners by goodFeaturesToTrack (quality 0.01, 5 px apart) where the truth
// is known, also those the right camera cannot see. Outlier: more than 2 px off. Required: answers
// for 60 % of the corners; measured are 76 % (median 0.31 px, 2.3 % outliers) and 72 % (0.11
// px, 4.6 %).
TEST_P(RealPairTest, CornersAreMatchedToAPartOfAPixel) {
  const RealPair& pair = GetParam();
  if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << kFolder << " is absent";
  const auto read = [](const std::string& name) {
    return cv::imread((kFolder / name).string(), cv::IMREAD_GRAYSCALE);
  };
  const cv::Mat left = read(pair.left), right = read(pair.right), truth = read(pair.truth);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(left, corners, 2000, 0.01, 5);
  std::vector<Eigen::Vector2d> at;
  std::vector<double> disparity;
  for (const cv::Point2f& corner : corners) {
    const int level = truth.at<std::uint8_t>(cv::Point(corner));
    if (level == 0) continue;  // not known
    at.emplace_back(corner.x, corner.y);
    disparity.push_back(level / pair.scale);
  }
  RowMatchOptions options;
  options.most = pair.most;
  const auto matches = MatchRows(left, right, at, options);
  std::vector<double> misses;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (matches[i].found) misses.push_back(std::abs(matches[i].disparity - disparity[i]));
  }
  std::sort(misses.begin(), misses.end());
  const auto within = std::upper_bound(misses.begin(), misses.end(), 2.0) - misses.begin();
  const auto found = static_cast<double>(misses.size());
  ASSERT_GE(found / static_cast<double>(at.size()), 0.6);
  RecordProperty("median_px", std::to_string(misses[misses.size() / 2]));
  EXPECT_LE(misses[misses.size() / 2], pair.median);
  EXPECT_LE(1 - static_cast<double>(within) / found, pair.outliers);
}

INSTANTIATE_TEST_SUITE_P(, RealPairTest,
                         testing::Values(RealPair{"aloeL.jpg", "aloeR.jpg", "aloeGT.png", 1, 255,
                                                  0.35, 0.15},
                                         RealPair{"cones_im2.png", "cones_im6.png",
                                                  "cones_disp2.png", 4, 64, 0.2, 0.07}));

// Reference: a texture known between the pixels, shifted. Tolerance: linear interpolation of its
// shortest waves (6 px) under a small window; measured is 0.032 px.
TEST(RowMatcherTest, DisparityIsLeftMinusRight) {
  WavyTexture texture;
  const cv::Mat left = texture.Picture({});
  const cv::Mat right = texture.Picture({Eigen::Matrix2d::Identity(), {-12.4, 0}});
  RowMatchOptions options;
  options.most = 40;
  for (const RowMatch& match : MatchRows(left, right, {{120, 100}, {200, 60}}, options)) {
    ASSERT_TRUE(match.found);
    EXPECT_NEAR(match.disparity, 12.4, 0.05);
  }
}

TEST(RowMatcherTest, WhatRepeatsIsRefused) {
  cv::Mat tiles(120, 320, CV_8UC1);
  for (int y = 0; y < tiles.rows; ++y) {
    for (int x = 0; x < tiles.cols; ++x) {
      tiles.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(120 + 50 * std::sin(0.4 * x) + 50 * std::sin(0.4 * y));
    }
  }
  RowMatchOptions options;
  options.most = 60;
  EXPECT_FALSE(MatchRows(tiles, tiles, {{150, 60}}, options).front().found);
}

TEST(RowMatcherTest, FlatOutsideAndBorderPlacesAreNotMatched) {
  const cv::Mat picture = WavyTexture().Picture({});
  const cv::Mat flat(240, 320, CV_8UC1, cv::Scalar(100));
  for (const RowMatch& match : MatchRows(picture, picture, {{2, 100}, {-50, 1e9}, {NAN, 3}}, {})) {
    EXPECT_FALSE(match.found);
  }
  EXPECT_FALSE(MatchRows(flat, flat, {{150, 100}}, {}).front().found);
  EXPECT_FALSE(MatchRows(picture, flat, {{150, 100}}, {}).front().found);
}

TEST(RowMatcherTest, PicturesAndRangesThatCannotBeAreRefused) {
  const cv::Mat picture = WavyTexture().Picture({});
  EXPECT_THROW(MatchRows(picture, picture(cv::Rect(0, 0, 300, 240)), {}, {}),
               std::invalid_argument);
  EXPECT_THROW(MatchRows(cv::Mat::zeros(240, 320, CV_16U), picture, {}, {}), std::invalid_argument);
  RowMatchOptions turned;
  turned.least = 10;
  turned.most = 5;
  EXPECT_THROW(MatchRows(picture, picture, {}, turned), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
