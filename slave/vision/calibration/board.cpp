#include "slave/vision/calibration/board.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
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

// OpenCV's own limits suit circles of 6 to 80 px.
cv::Ptr<cv::FeatureDetector> CircleFinder(const cv::Size& picture) {
  cv::SimpleBlobDetector::Params params;
  params.minArea = 20;
  params.maxArea = static_cast<float>(picture.area()) / 12;  // a grid has at least nine of them
  params.minDistBetweenBlobs = 5;
  return cv::SimpleBlobDetector::create(params);
}

// Dark on bright, then bright on dark; each by the graph of neighbours, then by the grid's outline,
// which finds some that are rolled by about a right angle.
bool FindCircles(const cv::Mat& grey, const Board& board, std::vector<cv::Point2f>* centres) {
  const cv::Size size(board.columns, board.rows);
  const int grid = board.pattern == Board::Pattern::kCircles ? cv::CALIB_CB_SYMMETRIC_GRID
                                                             : cv::CALIB_CB_ASYMMETRIC_GRID;
  const cv::Ptr<cv::FeatureDetector> finder = CircleFinder(grey.size());
  cv::Mat negative;
  cv::bitwise_not(grey, negative);
  for (const int way : {grid, grid | cv::CALIB_CB_CLUSTERING}) {
    for (const cv::Mat& shown : {grey, negative}) {
      if (cv::findCirclesGrid(shown, size, *centres, way, finder)) return true;
    }
  }
  return false;
}

// The point of `points` at `at`, up to a thousandth of `unit`.
std::optional<std::size_t> PointAt(const std::vector<cv::Point3f>& points,
                                   const Eigen::Vector3d& at, double unit) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::hypot(points[i].x - at.x(), points[i].y - at.y()) < 1e-3 * unit) return i;
  }
  return std::nullopt;
}

// The turn by `quarters` of a right angle about the middle; nullopt: it moves corners elsewhere.
std::optional<BoardSymmetry> Turned(const Board& board, int quarters) {
  const cv::Size2d extent = BoardExtent(board);
  const Eigen::Translation3d to_middle(extent.width / 2, extent.height / 2, 0);
  const Eigen::AngleAxisd turn(quarters * std::numbers::pi / 2, Eigen::Vector3d::UnitZ());
  BoardSymmetry symmetry;
  symmetry.X_BB = to_middle * turn * to_middle.inverse();
  const std::vector<cv::Point3f> points = BoardPoints(board);
  for (const cv::Point3f& p : points) {
    const auto at = PointAt(points, symmetry.X_BB * Eigen::Vector3d(p.x, p.y, p.z), board.square);
    if (!at) return std::nullopt;
    symmetry.order.push_back(*at);
  }
  return symmetry;
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
  const bool is_shifted = board.pattern == Board::Pattern::kAsymmetricCircles;
  const int across = is_shifted ? 2 * board.columns - (board.rows > 1 ? 1 : 2) : board.columns - 1;
  return {across * board.square, (board.rows - 1) * board.square};
}

std::vector<BoardSymmetry> SymmetriesOf(const Board& board) {
  std::vector<BoardSymmetry> symmetries;
  for (int quarters = 0; quarters < 4; ++quarters) {
    if (auto symmetry = Turned(board, quarters)) symmetries.push_back(*std::move(symmetry));
  }
  return symmetries;
}

Corners Reordered(const Corners& corners, const BoardSymmetry& symmetry) {
  Corners out;
  out.reserve(corners.size());
  for (const std::size_t i : symmetry.order) out.push_back(corners[i]);
  return out;
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

std::optional<Corners> FindBoard(const cv::Mat& grey, const Board& board) {
  Corners corners;
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

}  // namespace palpate
