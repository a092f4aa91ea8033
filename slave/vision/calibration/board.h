// The calibration board in a picture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace palpate {

struct Board {
  enum class Pattern { kChessboard, kCircles };
  Pattern pattern = Pattern::kChessboard;
  int columns = 0, rows = 0;  // inner corners, or circles; which is which does not matter
  double square = 0;          // between neighbours [m]

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
};

// One per corner, row after row [m]: x along a row, z = 0.
std::vector<cv::Point3f> BoardPoints(const Board& board);

// 8 or 16 bit, 1 or 3 channels -> 8 bit grey. Throws std::runtime_error for any other picture.
cv::Mat BoardGrey(const cv::Mat& picture);

// The corners [px] in the order of BoardPoints, refined below the pixel over a window of about a
// fifth of the distance to the neighbours; circles at the centres of their blobs. nullopt: not all
// of them are seen.
std::optional<std::vector<cv::Point2f>> FindBoard(const cv::Mat& grey, const Board& board);

// A board turned by half a turn looks the same to the finder: turns `right` so that its rows run as
// those of `left` do. Cameras of a pair are rolled against each other by less than a quarter turn.
void AlignCorners(const std::vector<cv::Point2f>& left, std::vector<cv::Point2f>* right);

}  // namespace palpate
