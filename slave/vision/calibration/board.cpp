#include "slave/vision/calibration/board.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

double NearestNeighbours(const std::vector<cv::Point2f>& corners, const Board& board) {
  double nearest = std::numeric_limits<double>::infinity();
  const auto columns = static_cast<std::size_t>(board.columns);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i % columns != 0) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - 1]));
    if (i >= columns) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - columns]));
  }
  return nearest;
}

bool FindCorners(const cv::Mat& grey, const Board& board, std::vector<cv::Point2f>* corners) {
  const cv::Size size(board.columns, board.rows);
  if (!cv::findChessboardCorners(grey, size, *corners) &&
      !cv::findChessboardCornersSB(grey, size, *corners, cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return false;
  }
  // A window that reaches a neighbour's edges is drawn to them, a small one hears the noise.
  const int half =
      static_cast<int>(std::clamp(std::lround(0.22 * NearestNeighbours(*corners, board)), 2L, 7L));
  const cv::TermCriteria settled(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-3);
  cv::cornerSubPix(grey, *corners, {half, half}, {-1, -1}, settled);
  return true;
}

bool FindCircles(const cv::Mat& grey, const Board& board, std::vector<cv::Point2f>* centres) {
  const cv::Size size(board.columns, board.rows);
  if (cv::findCirclesGrid(grey, size, *centres)) return true;
  cv::Mat negative;  // bright on dark
  cv::bitwise_not(grey, negative);
  return cv::findCirclesGrid(negative, size, *centres);
}

}  // namespace

std::vector<cv::Point3f> BoardPoints(const Board& board) {
  std::vector<cv::Point3f> points;
  for (int j = 0; j < board.rows; ++j) {
    for (int i = 0; i < board.columns; ++i) {
      points.emplace_back(static_cast<float>(i * board.square),
                          static_cast<float>(j * board.square), 0.0F);
    }
  }
  return points;
}

cv::Mat BoardGrey(const cv::Mat& picture) {
  const bool is_known = (picture.depth() == CV_8U || picture.depth() == CV_16U) &&
                        (picture.channels() == 1 || picture.channels() == 3);
  if (picture.empty() || !is_known) {
    throw std::runtime_error("is no picture of 8 or 16 bit, grey or colour");
  }
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  if (grey.depth() == CV_16U) cv::normalize(grey, grey, 0, 255, cv::NORM_MINMAX, CV_8U);
  return grey;
}

std::optional<std::vector<cv::Point2f>> FindBoard(const cv::Mat& grey, const Board& board) {
  std::vector<cv::Point2f> corners;
  const bool found = board.pattern == Board::Pattern::kChessboard
                         ? FindCorners(grey, board, &corners)
                         : FindCircles(grey, board, &corners);
  const bool is_whole = found && corners.size() == board.count() &&
                        std::all_of(corners.begin(), corners.end(), [](const cv::Point2f& p) {
                          return std::isfinite(p.x) && std::isfinite(p.y);
                        });
  if (!is_whole) return std::nullopt;
  return corners;
}

void AlignCorners(const std::vector<cv::Point2f>& left, std::vector<cv::Point2f>* right) {
  const cv::Point2f a = left.back() - left.front(), b = right->back() - right->front();
  if (a.dot(b) < 0) std::reverse(right->begin(), right->end());
}

}  // namespace palpate
