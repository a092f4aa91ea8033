// Printed chessboards of a calibration, and their detection in images.
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace palpate {

struct Board {
  int columns = 0, rows = 0;  // inner corners; which is which does not matter
  double square = 0;          // edge of a square [m]
};

using Corners = std::vector<cv::Point2f>;  // [px], row after row

// The corners, with x to y oriented as in the image. They begin at the same corner in every image
// if one count is odd and the other one even, because the colours of such a board show which end it
// is. `image`: 8 or 16 bit, 1 or 3 channels. nullopt: not all of them are visible.
std::optional<Corners> FindBoard(const cv::Mat& image, const Board& board);

}  // namespace palpate
