#include "slave/checks/load/flat_at_rest.h"

#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "slave/vision/dots/dot_layout.h"

namespace palpate {
namespace {

constexpr double kMembraneRadius = 0.039, kMembraneThickness = 1e-3, kPointSigma = 2e-5;  // [m]

std::vector<SurfacePoint> RestSurfaceOf(const std::function<double(double, double)>& height,
                                        double sigma = kPointSigma) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, sigma);
  std::vector<SurfacePoint> points;
  for (const Eigen::Vector2d& p : LatticePlaces(31, {0.015, 0.010})) {
    SurfacePoint point{.seen = true};
    point.p_S_rest = {p.x(), p.y(),
                      height(p.x() / kMembraneRadius, p.y() / kMembraneRadius) + noise(random)};
    point.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
    points.push_back(point);
  }
  return points;
}

// A tilt of the plane is part of the pose and is not checked here.
TEST(RestShapeTest, APlaneIsFlatHoweverItLies) {
  const auto tilted = RestSurfaceOf([](double x, double y) { return 0.01 + 2e-3 * x - 3e-3 * y; });
  const RestShape shape = RestShapeOf(tilted, kMembraneRadius);
  EXPECT_EQ(shape.points, 31);
  EXPECT_NEAR(shape.rms, kPointSigma, 0.5 * kPointSigma);
  EXPECT_LT(std::abs(shape.height), 4 * shape.sigma_height);
  EXPECT_TRUE(IsFlat(shape, kMembraneThickness));
}

TEST(RestShapeTest, ADomeAndAnIndentationAsHighAsAThirdOfTheThicknessAreSeen) {
  for (const double height : {3e-4, -3e-4, 2e-3}) {
    const auto dome = RestSurfaceOf([height](double x, double y) {
      const double within = 1 - x * x - y * y;
      return height * within * within;
    });
    const RestShape shape = RestShapeOf(dome, kMembraneRadius);
    EXPECT_NEAR(shape.height, height, 5 * shape.sigma_height);
    EXPECT_FALSE(IsFlat(shape, kMembraneThickness)) << height;
  }
  const auto aside = RestSurfaceOf(
      [](double x, double y) { return -1e-3 * std::exp(-((x - 0.5) * (x - 0.5) + y * y) / 0.04); });
  EXPECT_FALSE(IsFlat(RestShapeOf(aside, kMembraneRadius), kMembraneThickness));
}

TEST(RestShapeTest, WhatNoiseHidesIsNotFlagged) {
  for (const double sigma : {1e-4, 1e-3}) {
    EXPECT_TRUE(
        IsFlat(RestShapeOf(RestSurfaceOf([](double, double) { return 0; }, sigma), kMembraneRadius),
               kMembraneThickness))
        << sigma;
  }
  EXPECT_EQ(RestShapeOf({}, kMembraneRadius).points, 0);
  EXPECT_TRUE(IsFlat(RestShapeOf({}, kMembraneRadius), kMembraneThickness));
}

}  // namespace
}  // namespace palpate
