#include "slave/vision/calibration/board.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

cv::Mat GreyOf(const cv::Mat& image) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (grey.depth() == CV_16U) cv::normalize(grey, grey, 0, 255, cv::NORM_MINMAX, CV_8U);
  return grey;
}

// Returns the smallest distance between neighbours in a row or column [px].
double NearestNeighbours(const Corners& corners, std::size_t columns) {
  double nearest = HUGE_VAL;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i % columns != 0) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - 1]));
    if (i >= columns) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - columns]));
  }
  return nearest;
}

bool FindCorners(const cv::Mat& grey, const cv::Size& size, Corners* corners) {
  if (!cv::findChessboardCorners(grey, size, *corners) &&
      !cv::findChessboardCornersSB(grey, size, *corners, cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return false;
  }
  // A window that contains edges of a neighbour gives a wrong corner; a small window is sensitive
  // to noise.
  const double nearest = NearestNeighbours(*corners, static_cast<std::size_t>(size.width));
  const int half = static_cast<int>(std::clamp(std::lround(0.22 * nearest), 2L, 7L));
  const cv::TermCriteria settled(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-3);
  cv::cornerSubPix(grey, *corners, {half, half}, {-1, -1}, settled);
  return true;
}

// OpenCV's own limits suit circles of 6 to 80 px.
cv::Ptr<cv::FeatureDetector> CircleFinder(const cv::Size& image) {
  cv::SimpleBlobDetector::Params params;
  params.minArea = 20;
  params.maxArea = static_cast<float>(image.area()) / 12;  // a grid has at least nine of them
  params.minDistBetweenBlobs = 5;
  return cv::SimpleBlobDetector::create(params);
}

// Tries dark circles on bright, then bright on dark; each with the graph of neighbours and then
// with the grid's outline, which finds some grids that are rolled by about 90 degrees.
bool FindCircles(const cv::Mat& grey, const cv::Size& size, int grid, Corners* centres) {
  const cv::Ptr<cv::FeatureDetector> finder = CircleFinder(grey.size());
  for (const int way : {grid, grid | cv::CALIB_CB_CLUSTERING}) {
    for (const cv::Mat& shown : {grey, cv::Mat(255 - grey)}) {
      if (cv::findCirclesGrid(shown, size, *centres, way, finder)) return true;
    }
  }
  return false;
}

}  // namespace

std::vector<cv::Point3f> BoardPoints(const Board& board) {
  const bool is_shifted = board.pattern == Board::Pattern::kAsymmetricCircles;
  std::vector<cv::Point3f> points;
  for (int j = 0; j < board.rows; ++j) {
    for (int i = 0; i < board.columns; ++i) {
      const int across = is_shifted ? 2 * i + j % 2 : i;
      points.emplace_back(static_cast<float>(across * board.square),
                          static_cast<float>(j * board.square), 0.0F);
    }
  }
  return points;
}

cv::Size2d BoardExtent(const Board& board) {
  cv::Size2d extent;
  for (const cv::Point3f& p : BoardPoints(board)) {
    extent.width = std::max<double>(extent.width, p.x);
    extent.height = std::max<double>(extent.height, p.y);
  }
  return extent;
}

std::vector<Corners> OrdersOf(const Corners& corners, const Board& board) {
  std::vector<Corners> orders{corners};
  const bool is_asymmetric = board.pattern == Board::Pattern::kAsymmetricCircles;
  if (is_asymmetric && board.rows % 2 != 0) return orders;
  orders.emplace_back(corners.rbegin(), corners.rend());
  if (is_asymmetric || board.rows != board.columns) return orders;
  cv::Mat turned;
  cv::rotate(cv::Mat(corners).reshape(2, board.rows), turned, cv::ROTATE_90_CLOCKWISE);
  orders.emplace_back(turned.begin<cv::Point2f>(), turned.end<cv::Point2f>());
  orders.emplace_back(orders.back().rbegin(), orders.back().rend());
  return orders;
}

std::optional<Corners> FindBoard(const cv::Mat& image, const Board& board) {
  const cv::Mat grey = GreyOf(image);
  const cv::Size size(board.columns, board.rows);
  Corners corners;
  bool is_found = false;
  switch (board.pattern) {
    case Board::Pattern::kChessboard:
      is_found = FindCorners(grey, size, &corners);
      break;
    case Board::Pattern::kCircles:
      is_found = FindCircles(grey, size, cv::CALIB_CB_SYMMETRIC_GRID, &corners);
      break;
    case Board::Pattern::kAsymmetricCircles:
      is_found = FindCircles(grey, size, cv::CALIB_CB_ASYMMETRIC_GRID, &corners);
      break;
  }
  return is_found ? std::optional(corners) : std::nullopt;
}

}  // namespace palpate
