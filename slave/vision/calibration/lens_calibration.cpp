#include "slave/vision/calibration/lens_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/statistics/robust.h"

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
cv::Ptr<cv::FeatureDetector> CircleFinder(const cv::Size& image) {
  cv::SimpleBlobDetector::Params params;
  params.minArea = 20;
  params.maxArea = static_cast<float>(image.area()) / 12;  // a grid has at least nine of them
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

std::vector<Corners> OrdersOf(const Corners& corners, const Board& board) {
  std::vector<Corners> orders{corners};
  const bool is_asymmetric = board.pattern == Board::Pattern::kAsymmetricCircles;
  if (is_asymmetric && board.rows % 2 != 0) return orders;
  orders.emplace_back(corners.rbegin(), corners.rend());
  if (is_asymmetric || board.rows != board.columns) return orders;
  const auto n = static_cast<std::size_t>(board.columns);
  Corners turned;
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) turned.push_back(corners[i * n + n - 1 - j]);
  }
  orders.push_back(turned);
  orders.emplace_back(turned.rbegin(), turned.rend());
  return orders;
}

cv::Mat BoardGrey(const cv::Mat& image) {
  const bool is_known = (image.depth() == CV_8U || image.depth() == CV_16U) &&
                        (image.channels() == 1 || image.channels() == 3);
  if (image.empty() || !is_known) {
    throw std::runtime_error("is not an image of 8 or 16 bit, grey or colour");
  }
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
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

Board UnitBoard(Board board) {
  board.square = 1;
  return board;
}

cv::TermCriteria Settled() {
  return {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9};
}

cv::Matx33d CameraMatrixOf(const Lens& lens) {
  return {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
}

cv::Mat DistortionOf(const Lens& lens) {
  return cv::Mat(1, 5, CV_64F, const_cast<double*>(lens.distortion.data())).clone();
}

Lens LensOf(const cv::Mat& camera_matrix, const cv::Mat& distortion,
            const std::array<int, 2>& size) {
  Lens lens;
  lens.fx = camera_matrix.at<double>(0, 0), lens.cx = camera_matrix.at<double>(0, 2);
  lens.fy = camera_matrix.at<double>(1, 1), lens.cy = camera_matrix.at<double>(1, 2);
  const auto count = std::min<std::size_t>(distortion.total(), lens.distortion.size());
  std::copy_n(distortion.ptr<double>(), count, lens.distortion.begin());
  lens.size = size;
  const bool is_finite = std::isfinite(lens.cx) && std::isfinite(lens.cy) &&
                         std::isfinite(lens.fx + lens.fy) &&
                         std::all_of(lens.distortion.begin(), lens.distortion.end(),
                                     [](double d) { return std::isfinite(d); });
  if (!is_finite || !(lens.fx > 0) || !(lens.fy > 0)) {
    throw std::runtime_error("the images do not determine a lens: no focal length fits");
  }
  return lens;
}

Eigen::Isometry3d PoseOf(const cv::Mat& rotation, const cv::Mat& translation) {
  cv::Mat R = rotation;
  if (rotation.total() == 3) cv::Rodrigues(rotation, R);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    X.translation()[i] = translation.ptr<double>()[i];
    for (int j = 0; j < 3; ++j) X.linear()(i, j) = R.at<double>(i, j);
  }
  if (!X.matrix().allFinite()) throw std::runtime_error("the images do not determine a pose");
  return X;
}

LensCalibration CalibrateLens(const Board& board, const std::vector<Corners>& views,
                              const std::array<int, 2>& size) {
  if (views.size() < 2) throw std::runtime_error("fewer than two images do not determine a lens");
  const std::vector<std::vector<cv::Point3f>> boards(views.size(), BoardPoints(UnitBoard(board)));
  cv::Mat K, D, sigmas, sigmas_of_poses, per_view;
  std::vector<cv::Mat> rotations, translations;
  LensCalibration out;
  try {
    out.rms_px =
        cv::calibrateCamera(boards, views, {size[0], size[1]}, K, D, rotations, translations,
                            sigmas, sigmas_of_poses, per_view, cv::CALIB_FIX_K3, Settled());
    out.lens = LensOf(K, D, size);
    for (std::size_t i = 0; i < views.size(); ++i) {
      out.X_CB.push_back(PoseOf(rotations[i], board.square * translations[i]));
      out.view_rms_px.push_back(per_view.at<double>(static_cast<int>(i)));
    }
  } catch (const cv::Exception&) {
    throw std::runtime_error(
        "the images do not determine a lens: the poses of the board are too similar");
  }
  out.sigma_focal =
      std::max(sigmas.at<double>(0) / out.lens.fx, sigmas.at<double>(1) / out.lens.fy);
  return out;
}

CameraCalibration CalibrateCamera(const Board& board, const std::vector<Corners>& views,
                                  const std::array<int, 2>& size) {
  CameraCalibration out;
  for (std::size_t i = 0; i < views.size(); ++i) out.used.push_back(i);
  std::vector<Corners> used = views;
  for (;;) {
    out.fit = CalibrateLens(board, used, size);
    const auto worst = Outlier(out.fit.view_rms_px, kCornerPixels);
    if (!worst) return out;
    const auto at = static_cast<std::ptrdiff_t>(*worst);
    out.dropped.push_back({out.used[*worst], out.fit.view_rms_px[*worst]});
    out.used.erase(out.used.begin() + at);
    used.erase(used.begin() + at);
  }
}

std::optional<std::size_t> Outlier(const std::vector<double>& misses, double pixels) {
  constexpr double kTimesMedian = 3;
  const auto worst = std::max_element(misses.begin(), misses.end());
  if (*worst <= std::max(kTimesMedian * MedianOf(std::vector(misses)), pixels)) return std::nullopt;
  return static_cast<std::size_t>(worst - misses.begin());
}

}  // namespace palpate
