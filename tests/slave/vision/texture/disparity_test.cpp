#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/vision/texture/row_matcher.h"

namespace palpate {
namespace {

const std::filesystem::path kFolder = PALPATE_SOURCE_DIR "/../shared/data/stereo_disparity";

struct RealPair {
  const char* left;
  const char* right;
  const char* truth;
  double scale;             // truth's levels per pixel of disparity
  int most;                 // disparity searched [px]
  double median, outliers;  // required
};

class RealPairTest : public testing::TestWithParam<RealPair> {};

TEST_P(RealPairTest, CornersAreMatched) {
  const RealPair& pair = GetParam();
  if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << kFolder << " is absent";
  const cv::Mat left = cv::imread((kFolder / pair.left).string(), cv::IMREAD_GRAYSCALE);
  const cv::Mat right = cv::imread((kFolder / pair.right).string(), cv::IMREAD_GRAYSCALE);
  const cv::Mat truth = cv::imread((kFolder / pair.truth).string(), cv::IMREAD_GRAYSCALE);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(left, corners, 2000, 0.01, 5);
  std::vector<Eigen::Vector2d> at;
  std::vector<double> disparity;
  for (const cv::Point2f& corner : corners) {
    const int level = truth.at<std::uint8_t>(cv::Point(corner));
    if (level == 0) continue;
    at.emplace_back(corner.x, corner.y);
    disparity.push_back(level / pair.scale);
  }
  for (int window : {9, 11, 13, 15, 19, 23}) {
    RowMatchOptions options;
    options.most = pair.most;
    options.window = window;
    const auto matches = MatchRows(left, right, at, options);
    std::vector<double> misses;
    int bad = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (!matches[i].found) continue;
      misses.push_back(std::abs(matches[i].disparity - disparity[i]));
      bad += misses.back() > 2;
    }
    std::sort(misses.begin(), misses.end());
    std::printf("%s window %d: %zu of %zu (%.1f %%), median %.3f px, outliers %.1f %%\n", pair.left,
                window, misses.size(), at.size(), 100 * double(misses.size()) / double(at.size()),
                misses[misses.size() / 2], 100.0 * bad / double(misses.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(, RealPairTest,
                         testing::Values(RealPair{"aloeL.jpg", "aloeR.jpg", "aloeGT.png", 1, 255,
                                                  0.35, 0.15},
                                         RealPair{"cones_im2.png", "cones_im6.png",
                                                  "cones_disp2.png", 4, 64, 0.2, 0.07}));

}  // namespace
}  // namespace palpate
