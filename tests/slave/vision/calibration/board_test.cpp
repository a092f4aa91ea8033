#include "slave/vision/calibration/board.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/vision/stereo/rig.h"

namespace palpate {
namespace {

const Board kBoard{9, 6, 0.010};
const Lens kLens{600, 600, 319.5, 239.5, {}, {640, 480}};

// The image of a board whose first inner corner is the origin of B, with 4 x 4 rays per pixel.
cv::Mat DrawBoard(const Eigen::Isometry3d& X_CB) {
  constexpr int kFine = 4;
  const Eigen::Isometry3d X_BC = X_CB.inverse();
  cv::Mat image(kLens.size[1], kLens.size[0], CV_8U);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      int dark = 0;
      for (int k = 0; k < kFine * kFine; ++k) {
        const Eigen::Vector2d p_I(u + (k % kFine + 0.5) / kFine - 0.5,
                                  v + (k / kFine + 0.5) / kFine - 0.5);
        const Eigen::Vector3d ray = X_BC.linear() * RayOf(kLens, p_I)->homogeneous();
        const Eigen::Vector3d eye = X_BC.translation();
        const Eigen::Vector3d at = (eye - eye.z() / ray.z() * ray) / kBoard.square;
        const int i = static_cast<int>(std::floor(at.x())),
                  j = static_cast<int>(std::floor(at.y()));
        const bool is_on_board = i >= -1 && i < kBoard.columns && j >= -1 && j < kBoard.rows;
        dark += is_on_board && (i + j) % 2 == 0 ? 1 : 0;
      }
      image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(220 - 190 * dark / (kFine * kFine));
    }
  }
  return image;
}

// Reference: the pinhole image of each corner. Tolerance: the drawn edges are sampled four times
// per pixel; measured 0.10 px. For any roll of the camera the corners begin at the same end of the
// board.
TEST(BoardTest, CornersOfATiltedBoardAreFoundFromTheSameEnd) {
  std::vector<std::size_t> ends;
  for (int k = 0; k < 4; ++k) {
    Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();
    X_CB.translation().z() = 0.20;
    X_CB.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 0.4, 0.2).normalized()))
        .rotate(Eigen::AngleAxisd(0.1 + k * M_PI / 2, Eigen::Vector3d::UnitZ()))
        .translate(Eigen::Vector3d(-0.04, -0.025, 0));
    const auto found = FindBoard(DrawBoard(X_CB), kBoard);
    ASSERT_TRUE(found) << k;
    ASSERT_EQ(found->size(), 54U);
    const auto miss = [&](std::size_t corner, std::size_t as) {
      const Eigen::Vector3d p_B(0.010 * static_cast<double>(as % 9),
                                0.010 * static_cast<double>(as / 9), 0);
      const cv::Point2f& p = (*found)[corner];
      return (*Project(kLens, X_CB * p_B) - Eigen::Vector2d(p.x, p.y)).norm();
    };
    ends.push_back(miss(0, 0) < miss(0, 53) ? 0U : 53U);
    for (std::size_t i = 0; i < 54; ++i) {
      EXPECT_LT(miss(i, ends.back() == 0 ? i : 53 - i), 0.15) << k << ' ' << i;
    }
  }
  EXPECT_EQ(ends, std::vector(4, ends.front()));
}

TEST(BoardTest, ABoardThatIsPartlyOutsideIsNotFound) {
  Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();
  X_CB.translation() = Eigen::Vector3d(0, 0, 0.20);
  EXPECT_TRUE(FindBoard(DrawBoard(X_CB * Eigen::Translation3d(-0.04, -0.025, 0)), kBoard));
  EXPECT_FALSE(FindBoard(DrawBoard(X_CB * Eigen::Translation3d(0.05, -0.025, 0)), kBoard));
}

}  // namespace
}  // namespace palpate
