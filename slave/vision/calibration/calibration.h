// Calibration of a lens or a stereo pair from images of a board, and the verdict whether it may be
// trusted: a small residual shows that the numbers fit these images, not that other images would
// give the same ones.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/vision/calibration/board.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// A view of the board by one camera, or by both at the same time.
struct BoardView {
  Corners left, right;  // right: of pairs
};

struct ImageSizes {
  std::array<int, 2> left{}, right{};  // [px]; right: of pairs
};

struct Calibration {
  Board board;
  bool is_pair = false;
  StereoRig rig;                  // one camera: `left`
  std::vector<std::size_t> used;  // indices of the used views, rising; as the lists below
  std::vector<BoardView> views;   // right corners in the order of the left ones
  std::vector<std::array<double, 2>> rms_px;  // of the left and the right image
  std::vector<Eigen::Isometry3d> X_LB;        // poses of the board [m]
  std::vector<double> own_px;                 // of pairs, with a pose of the board for each camera
  struct Dropped {
    std::size_t view = 0;
    double miss_px = 0;  // rms
  };
  std::vector<Dropped> dropped;  // views that contradict the others
  double sigma_focal = 0;        // of the fit, of the less certain camera, relative
  // Relative standard deviation of the baseline (one camera: of the focal length), from fits to
  // halves of the views. Views with nearly the same pose of the board are not independent, so they
  // are in the same half.
  double sigma = 0;
  std::size_t distinct = 0;          // number of views with different poses of the board
  std::vector<double> coverage;      // share of the 8 x 6 cells of each camera's image with corners
  std::vector<std::string> reasons;  // why it cannot be trusted; empty: it may
  std::vector<std::string> warnings;  // weak points that do not cause a rejection
};

// Least squares of the reprojection by OpenCV, k1 k2 p1 p2; k3 stays 0, because boards seldom reach
// the image corners, which are needed to distinguish it from k2. For pairs each camera is fitted
// separately, then both lenses, X_RL and all poses of the board together. Views are dropped if
// their error is three times the median (blurred, bent, or another board), and pairs if one pose of
// the board fits worse than a pose for each camera (the board moved between the exposures). The
// right corners of a pair may begin at another corner (OrdersOf). Throws std::runtime_error with a
// sentence: fewer than three views, or views that determine no lens or no pair.
Calibration Calibrate(const Board& board, const std::vector<BoardView>& views,
                      const ImageSizes& sizes);

// Returns whether the camera given as the right one is to the left of the other.
bool AreSidesExchanged(const StereoRig& rig);

// The rectification R1, R2, P1, P2, Q of a rig, in OpenCV's terms: the same rows of both images
// show the same points.
std::vector<NamedMatrix> Rectification(const StereoRig& rig);

// OpenCV's forms of a lens and a pose. PoseOf throws std::runtime_error where it is not finite;
// `rotation`: vector or matrix.
cv::Matx33d CameraMatrixOf(const Lens& lens);
cv::Mat DistortionOf(const Lens& lens);
Eigen::Isometry3d PoseOf(const cv::Mat& rotation, const cv::Mat& translation);

}  // namespace palpate
