#include "slave/vision/stereo/lens_warp.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/slave/vision/stereo/test_rigs.h"

namespace palpate {
namespace {

constexpr std::array<double, 5> kWarpBarrel{-0.25, 0.08, 0.001, -0.0005, 0};

// Reference: a pinhole's image of the same point.
TEST(LensWarpTest, StraightPlacesAreAPinholes) {
  Lens lens = TestLens(kWarpBarrel);
  lens.fx = 810, lens.fy = 790;
  const double f = std::sqrt(810.0 * 790.0);
  for (const double x : {-0.08, 0.0, 0.05}) {
    for (const double y : {-0.05, 0.02, 0.06}) {
      const auto at = Straight(lens, *Project(lens, {x, y, 0.25}));
      ASSERT_TRUE(at);
      EXPECT_LT((*at - Eigen::Vector2d(320 + f * x / 0.25, 240 + f * y / 0.25)).norm(), 1e-9);
    }
  }
  EXPECT_FALSE(Straight(lens, {NAN, 0}));
}

// Waves of 40 px over the whole range of grey levels.
cv::Mat Waves(const Lens& lens, bool bent) {
  cv::Mat image(lens.size[1], lens.size[0], CV_8U);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector2d p_I(u, v);
      const Eigen::Vector2d at = bent ? Straight(lens, p_I).value() : p_I;
      const double wave = std::sin(at.x() / 40 * 2 * M_PI) + std::cos(at.y() / 40 * 2 * M_PI);
      image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(std::lround(127.5 + 60 * wave));
    }
  }
  return image;
}

// Reference: the waves as they are, and as the lens bends them, point by point. Tolerance: a 64th
// of a pixel where they rise by up to 13 levels per px is 0.2, chords for curves 0.4, two
// roundings 1.
TEST(LensWarpTest, ImagesAreStraightenedAndBent) {
  const Lens lens = TestLens(kWarpBarrel);
  const cv::Rect inside(8, 8, 624, 464);  // visible in both images
  const auto worst = [&](const cv::Mat& a, const cv::Mat& b) {
    cv::Mat miss;
    cv::absdiff(a(inside), b(inside), miss);
    double most = 0;
    cv::minMaxLoc(miss, nullptr, &most);
    return most;
  };
  EXPECT_LE(worst(LensWarp::Straightening(lens).Apply(Waves(lens, true)), Waves(lens, false)), 2);
  const cv::Mat expected = Waves(lens, true);
  cv::Mat bent = LensWarp::Distorting(lens).Apply(Waves(lens, false));
  // Pixels outside the corrected image are not compared.
  for (int v = 0; v < bent.rows; ++v) {
    for (int u = 0; u < bent.cols; ++u) {
      const Eigen::Vector2d at = Straight(lens, Eigen::Vector2d(u, v)).value();
      const bool is_seen = at.x() >= 0 && at.y() >= 0 && at.x() <= 639 && at.y() <= 479;
      if (!is_seen) bent.at<std::uint8_t>(v, u) = expected.at<std::uint8_t>(v, u);
    }
  }
  EXPECT_LE(worst(bent, expected), 2);
  EXPECT_GT(worst(expected, Waves(lens, false)), 100);  // otherwise the test has no effect
}

}  // namespace
}  // namespace palpate
