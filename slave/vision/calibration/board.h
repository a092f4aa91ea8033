// Boards of a calibration: their points, and their detection in images.
#pragma once

#include <optional>
#include <vector>

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
};

using Corners = std::vector<cv::Point2f>;  // [px], in the order of BoardPoints

// Returns one point per corner, row after row [m]: x along a row, z = 0.
std::vector<cv::Point3f> BoardPoints(const Board& board);
// Width and height of the points of BoardPoints [m].
cv::Size2d BoardExtent(const Board& board);

// The orders of `corners` that a detector cannot distinguish: as given, from the last corner to the
// first, and on a square board also after a quarter turn. Asymmetric circles with an odd number of
// rows have one order.
std::vector<Corners> OrdersOf(const Corners& corners, const Board& board);

// The corners in the order of BoardPoints up to a symmetry, with x to y oriented as in the image.
// For circles the centres of their blobs, dark on bright or bright on dark. `image`: 8 or 16 bit, 1
// or 3 channels. nullopt: not all of them are visible.
std::optional<Corners> FindBoard(const cv::Mat& image, const Board& board);

}  // namespace palpate
