// One camera's lens from pictures of a board.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/types.hpp>

#include "slave/vision/calibration/board.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

struct LensCalibration {
  Lens lens;
  double rms_px = 0;
  double sigma_focal = 0;               // relative, as the corners' scatter has it
  std::vector<double> view_rms_px;      // one per picture
  std::vector<Eigen::Isometry3d> X_CB;  // of the board, one per picture [m]
};

// Least squares of reprojection, k1 k2 p1 p2; k3 stays 0: boards seldom reach the picture's
// corners, which alone tell it from k2. Throws std::runtime_error in words where the pictures
// define no lens.
LensCalibration CalibrateLens(const Board& board, const std::vector<Corners>& views,
                              const std::array<int, 2>& size);

struct CameraCalibration {
  LensCalibration fit;            // of what is used
  std::vector<std::size_t> used;  // of the views given, rising; fit's lists are in this order
  struct Dropped {
    std::size_t view = 0;
    double miss_px = 0;  // rms
  };
  std::vector<Dropped> dropped;  // views that contradict the others
};

// CalibrateLens without the views whose corners are off by three times the median and kCornerPixels
// or more: blurred, bent, or of another board.
CameraCalibration CalibrateCamera(const Board& board, const std::vector<Corners>& views,
                                  const std::array<int, 2>& size);

double Median(std::vector<double> values);  // not empty; the upper one of two
// The worst of `misses`, if it contradicts the rest: three times their median, and `pixels`.
std::optional<std::size_t> Outlier(const std::vector<double>& misses, double pixels);
constexpr double kCornerPixels = 0.6;  // rms; an honest picture's are less

// OpenCV iterates until the norm of all parameters settles, focal lengths of hundreds of pixels
// among them: places count for something in it where the unit is a square, and the answer does not
// hang on the unit.
Board UnitBoard(Board board);
cv::TermCriteria Settled();
// OpenCV's forms of a lens.
cv::Matx33d CameraMatrixOf(const Lens& lens);
cv::Mat DistortionOf(const Lens& lens);
// Throws std::runtime_error where the numbers make no lens.
Lens LensOf(const cv::Mat& camera_matrix, const cv::Mat& distortion,
            const std::array<int, 2>& size);
// rotation: vector or matrix. Throws std::runtime_error where it is not finite.
Eigen::Isometry3d PoseOf(const cv::Mat& rotation, const cv::Mat& translation);

}  // namespace palpate
