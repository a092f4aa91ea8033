#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "master/view/shape_layers.h"

namespace palpate {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

const std::vector<Eigen::Vector3d> kDirections{{1, 0, 0}, {-1, 0, 0},  {0, 1, 0},       {0, -1, 0},
                                               {1, 1, 0}, {1, -2, 1},  {-0.3, 0.9, -1}, {0, 0, 1},
                                               {0, 0, 0}, {kNan, 0, 0}};

// Reference: a parallel projection along unit vectors at right angles keeps, over any three
// directions at right angles, the sum of squared lengths: 1 + 1 of the two axes and 1 of the depth.
TEST(ViewpointTest, IsAParallelProjectionWithoutDistortion) {
  for (const Eigen::Vector3d& along : kDirections) {
    const Viewpoint view = Viewpoint::Across(along);
    double lengths = 0, depths = 0;
    for (const Eigen::Vector3d& axis :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
      lengths += view.Direction(axis, 1).squaredNorm();
      depths += view.Nearness(axis) * view.Nearness(axis);
    }
    EXPECT_NEAR(lengths, 2, 1e-12) << along.transpose();
    EXPECT_NEAR(depths, 1, 1e-12) << along.transpose();
  }
}

// Reference: 20 degrees aside leave cos 20 = 0.94 of a horizontal way across the picture.
TEST(ViewpointTest, WhatHappensAlongTheDirectionIsSeenFromTheSideWithZUp) {
  for (const Eigen::Vector3d& along : kDirections) {
    const Viewpoint view = Viewpoint::Across(along);
    const Eigen::Vector2d up = view.Direction({0, 0, 1}, 1);
    EXPECT_NEAR(up.x(), 0, 1e-12) << along.transpose();
    EXPECT_LT(up.y(), -0.8) << along.transpose();
    EXPECT_GT(view.Nearness({0, 0, 1}), 0) << "from above";
    EXPECT_GE(view.Direction({1, 0, 0}, 1).x(), 0) << "x runs to the right";
    Eigen::Vector3d flat(along.x(), along.y(), 0);
    if (!(flat.norm() > 0)) flat = {1, 0, 0};
    EXPECT_NEAR(std::abs(view.Direction(flat.normalized(), 1).x()), 0.9397, 1e-4)
        << along.transpose();
  }
}

TEST(ViewpointTest, FitsWhatIsSeenIntoTheRectangleAndFillsIt) {
  Viewpoint view = Viewpoint::Front();
  const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {0.2, 0.1, 0}};
  view.Fit(points, {10, 20}, {100, 80});
  EXPECT_NEAR(view.scale(), 500, 1e-9);
  EXPECT_LT((view.ToPicture(points[0]) - Eigen::Vector2d(10, 85)).norm(), 1e-9);
  EXPECT_LT((view.ToPicture(points[1]) - Eigen::Vector2d(110, 35)).norm(), 1e-9);
}

TEST(ViewpointTest, NothingOrAPointIsShownInTheMiddle) {
  for (const std::vector<Eigen::Vector3d>& points :
       {std::vector<Eigen::Vector3d>{}, std::vector<Eigen::Vector3d>{{0, 0, 0}}}) {
    Viewpoint view = Viewpoint::Across({1, 0, 0});
    view.Fit(points, {10, 20}, {100, 80});
    EXPECT_LT((view.ToPicture({0, 0, 0}) - Eigen::Vector2d(60, 60)).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace palpate
