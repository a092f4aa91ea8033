// The calibration board in a picture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

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
// Width and height of what BoardPoints spans [m].
cv::Size2d BoardExtent(const Board& board);

// A turn of the board about its normal that carries every corner to a corner: a finder cannot tell
// it from no turn.
struct BoardSymmetry {
  std::vector<std::size_t> order;  // corner i lies where corner order[i] was
  Eigen::Isometry3d X_BB = Eigen::Isometry3d::Identity();
};
// The first is no turn; a square board has four.
std::vector<BoardSymmetry> SymmetriesOf(const Board& board);
Corners Reordered(const Corners& corners, const BoardSymmetry& symmetry);

// 8 or 16 bit, 1 or 3 channels -> 8 bit grey. Throws std::runtime_error for any other picture.
cv::Mat BoardGrey(const cv::Mat& picture);

// The corners in the order of BoardPoints up to a symmetry, x to y turning as in the picture;
// refined below the pixel over a window of about a fifth of the distance to the neighbours. Circles
// at the centres of their blobs, dark on bright or bright on dark. nullopt: not all of them are
// seen.
std::optional<Corners> FindBoard(const cv::Mat& grey, const Board& board);

}  // namespace palpate
