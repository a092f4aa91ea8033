#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/simulator/environment/painting.h"

namespace palpate::simulation {
namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

double AreaOf(const Polygon& p) {
  double twice = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Point &a = p[i], &b = p[(i + 1) % p.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

// Reference: areas calculated by hand. Pixel (x, y) spans x - 0.5 to x + 0.5. Tolerance: single
// precision.
TEST(Coverage, AnAlignedRectangleCoversItsPartOfEachPixel) {
  const cv::Mat alpha =
      CoverageOf({{{0.75, 0.9}, {3.2, 0.9}, {3.2, 2.6}, {0.75, 2.6}}}, {0, 0, 6, 5});
  EXPECT_NEAR(alpha.at<float>(2, 2), 1, 1e-6);
  EXPECT_NEAR(alpha.at<float>(2, 1), 0.75, 1e-6);
  EXPECT_NEAR(alpha.at<float>(2, 3), 0.7, 1e-6);
  EXPECT_NEAR(alpha.at<float>(1, 2), 0.6, 1e-6);
  EXPECT_NEAR(alpha.at<float>(3, 3), 0.1 * 0.7, 1e-6);
  EXPECT_NEAR(alpha.at<float>(0, 2), 0, 1e-6);
  EXPECT_NEAR(alpha.at<float>(2, 4), 0, 1e-6);
}

// Reference: the shoelace formula; a slanted polygon and one with a hole.
TEST(Coverage, SumsToTheArea) {
  Polygon star;
  for (int k = 0; k < 14; ++k) {
    const double angle = 2 * std::numbers::pi * k / 14, r = k % 2 == 0 ? 14.3 : 6.1;
    star.emplace_back(20.37 + r * std::cos(angle), 19.81 + r * std::sin(angle));
  }
  EXPECT_NEAR(cv::sum(CoverageOf({star}, {0, 0, 40, 40}))[0], AreaOf(star), 1e-3);
  const Polygon hole{{18, 18}, {18, 21}, {22, 21}, {22, 18}};
  EXPECT_NEAR(cv::sum(CoverageOf({star, hole}, {0, 0, 40, 40}))[0], AreaOf(star) - 12, 1e-3);
}

}  // namespace
}  // namespace palpate::simulation
