// Calibration of one camera's lens from images of a board, and detection of the board.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "slave/vision/stereo/rig.h"

namespace palpate {

// kCircles: a rectangular grid. kAsymmetricCircles: every other row is shifted by half the distance
// of neighbours in a row, which is twice the distance of rows (as OpenCV's 4x11 grid has it).
struct Board {
  enum class Pattern { kChessboard, kCircles, kAsymmetricCircles };
  Pattern pattern = Pattern::kChessboard;
  // Inner corners, or circles; of chessboards and rectangular grids which is which does not matter.
  int columns = 0, rows = 0;
  double square = 0;  // between neighbours; asymmetric circles: between rows [m]

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
};

using Corners = std::vector<cv::Point2f>;  // [px], in the order of BoardPoints

// One per corner, row after row [m]: x along a row, z = 0.
std::vector<cv::Point3f> BoardPoints(const Board& board);
// Width and height of the points of BoardPoints [m].
cv::Size2d BoardExtent(const Board& board);

// The orders of `corners` that a detector cannot distinguish: as given, from the last corner to the
// first, and on a square board also after a quarter turn. Asymmetric circles with an odd number of
// rows have one order.
std::vector<Corners> OrdersOf(const Corners& corners, const Board& board);

// 8 or 16 bit, 1 or 3 channels -> 8 bit grey. Throws std::runtime_error for any other image.
cv::Mat BoardGrey(const cv::Mat& image);

// The corners in the order of BoardPoints up to a symmetry, with x to y oriented as in the image;
// refined to sub-pixel accuracy over a window of about a fifth of the distance to the neighbours.
// For circles the centres of their blobs, dark on bright or bright on dark. nullopt: not all of
// them are visible.
std::optional<Corners> FindBoard(const cv::Mat& grey, const Board& board);

struct LensCalibration {
  Lens lens;
  double rms_px = 0;
  double sigma_focal = 0;               // relative, as the corners' scatter has it
  std::vector<double> view_rms_px;      // one per image
  std::vector<Eigen::Isometry3d> X_CB;  // poses of the board, one per image [m]
};

// Least squares of the reprojection, k1 k2 p1 p2; k3 stays 0, because boards seldom reach the image
// corners, which are needed to distinguish it from k2. Throws std::runtime_error with a sentence if
// the images determine no lens.
LensCalibration CalibrateLens(const Board& board, const std::vector<Corners>& views,
                              const std::array<int, 2>& size);

struct CameraCalibration {
  LensCalibration fit;  // of the used views
  std::vector<std::size_t>
      used;  // indices of the used views, rising; the lists of fit have this order
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

// The worst of `misses`, if it contradicts the rest: three times their median, and `pixels`.
std::optional<std::size_t> Outlier(const std::vector<double>& misses, double pixels);
constexpr double kCornerPixels = 0.6;  // limit of the rms; correct images have less

// OpenCV iterates until the norm of all parameters converges, including focal lengths of hundreds
// of pixels. With the square as unit, positions have a comparable weight, and the result does not
// depend on the unit.
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
