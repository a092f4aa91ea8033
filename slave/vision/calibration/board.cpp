#include "slave/vision/calibration/board.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {

std::optional<Corners> FindBoard(const cv::Mat& image, const Board& board) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (grey.depth() == CV_16U) cv::normalize(grey, grey, 0, 255, cv::NORM_MINMAX, CV_8U);
  // Part of a larger board is no board: kFlags make the detector report the size it sees.
  constexpr int kFlags =
      cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_LARGER;
  const cv::Size size(board.columns, board.rows);
  Corners corners;
  cv::Mat seen;
  if (!cv::findChessboardCornersSB(grey, size, corners, kFlags, seen) || seen.size() != size) {
    return std::nullopt;
  }
  // A window that contains edges of a neighbour gives a wrong corner; a small window is sensitive
  // to noise.
  const auto columns = static_cast<std::size_t>(board.columns);
  double nearest = HUGE_VAL;  // distance of neighbours in a row or column [px]
  for (std::size_t i = columns; i < corners.size(); ++i) {
    nearest = std::min(nearest, cv::norm(corners[i] - corners[i - columns]));
    if (i % columns != 0) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - 1]));
  }
  const int half = static_cast<int>(std::clamp(std::lround(0.22 * nearest), 2L, 7L));
  const cv::TermCriteria settled(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-3);
  cv::cornerSubPix(grey, corners, {half, half}, {-1, -1}, settled);
  return corners;
}

}  // namespace palpate
