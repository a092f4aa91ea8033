#include "slave/vision/calibration/board.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "slave/vision/stereo/rig.h"
#include "tests/slave/vision/calibration/drawn_circles.h"

namespace palpate {
namespace {

// Reference: each order is a rotation of the board's points onto themselves.
TEST(BoardTest, OrdersAreRotationsOfTheBoardOntoItself) {
  struct Case {
    Board board;
    std::size_t count;
  };
  for (const auto& [board, count] : {Case{{Board::Pattern::kChessboard, 9, 6, 0.01}, 2},
                                     Case{{Board::Pattern::kCircles, 6, 6, 0.01}, 4},
                                     Case{{Board::Pattern::kAsymmetricCircles, 4, 10, 0.01}, 2},
                                     Case{{Board::Pattern::kAsymmetricCircles, 4, 11, 0.01}, 1}}) {
    Corners points;
    for (const cv::Point3f& p : BoardPoints(board)) points.emplace_back(p.x, p.y);
    const auto orders = OrdersOf(points, board);
    EXPECT_EQ(orders.size(), count);
    for (const Corners& order : orders) {
      Eigen::Matrix2Xd from(2, points.size()), to(2, points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        from.col(static_cast<Eigen::Index>(i)) << points[i].x, points[i].y;
        to.col(static_cast<Eigen::Index>(i)) << order[i].x, order[i].y;
      }
      const Eigen::Matrix3d X = Eigen::umeyama(from, to, false);
      const Eigen::Matrix2Xd moved = (X * from.colwise().homogeneous()).topRows(2);
      EXPECT_LT((moved - to).norm(), 1e-6) << board.columns << " x " << board.rows;
    }
  }
}

// For any roll of the camera; a board seen from behind would be another board.
TEST(BoardTest, CornersTurnAsTheyDoOnTheBoard) {
  const Lens lens{300, 300, 159.5, 119.5, {}, {320, 240}};
  for (const Board& board :
       {Board{Board::Pattern::kCircles, 6, 5, 0.012}, Board{Board::Pattern::kCircles, 5, 6, 0.012},
        Board{Board::Pattern::kAsymmetricCircles, 4, 9, 0.010}}) {
    const cv::Size2d extent = BoardExtent(board);
    for (int k = 0; k < 4; ++k) {
      Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();
      X_CB.translation().z() = 0.18;
      X_CB.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))
          .rotate(Eigen::AngleAxisd(0.1 + k * M_PI / 2, Eigen::Vector3d::UnitZ()))
          .translate(Eigen::Vector3d(-extent.width / 2, -extent.height / 2, 0));
      const auto found = FindBoard(DrawCircles(board, 0.0035, lens, X_CB), board);
      ASSERT_TRUE(found) << board.rows << " " << k;
      const cv::Point2f along = (*found)[1] - (*found)[0];
      const cv::Point2f down = (*found)[2 * static_cast<std::size_t>(board.columns)] - (*found)[0];
      EXPECT_GT(along.cross(down), 0) << board.rows << " " << k;
    }
  }
}

// Reference: the pinhole image of each centre plus the bias of a tilted disc's centroid (reference
// g). Tolerance: the blob finder counts whole pixels.
TEST(BoardTest, TiltedCirclesAreFoundAtTheirMiddles) {
  const Lens lens{300, 300, 159.5, 119.5, {}, {320, 240}};
  for (const Board& board : {Board{Board::Pattern::kCircles, 7, 5, 0.012},
                             Board{Board::Pattern::kAsymmetricCircles, 4, 9, 0.010}}) {
    const cv::Size2d extent = BoardExtent(board);
    Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();
    X_CB.translation().z() = 0.14;
    X_CB.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 0.4, 0.2).normalized()))
        .translate(Eigen::Vector3d(-extent.width / 2, -extent.height / 2, 0));
    constexpr double kRadius = 0.0035;
    const auto found = FindBoard(DrawCircles(board, kRadius, lens, X_CB), board);
    ASSERT_TRUE(found);
    const auto points = BoardPoints(board);
    const auto miss = [&](const Corners& corners) {
      double most = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d p_C = X_CB * Eigen::Vector3d(points[i].x, points[i].y, points[i].z);
        const Eigen::Vector2d middle =
            *Project(lens, p_C) + *CircleCentroidBias(lens, p_C, X_CB.linear().col(2), kRadius);
        most = std::max(most, (middle - Eigen::Vector2d(corners[i].x, corners[i].y)).norm());
      }
      return most;
    };
    double least = HUGE_VAL;
    for (const Corners& order : OrdersOf(*found, board)) least = std::min(least, miss(order));
    EXPECT_LT(least, 0.15) << board.rows;
  }
}

}  // namespace
}  // namespace palpate
