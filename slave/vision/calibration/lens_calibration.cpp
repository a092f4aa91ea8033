#include "slave/vision/calibration/lens_calibration.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opencv2/calib3d.hpp>

namespace palpate {

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
    throw std::runtime_error("the pictures define no lens: no focal length fits them");
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
  if (!X.matrix().allFinite()) throw std::runtime_error("the pictures define no pose");
  return X;
}

LensCalibration CalibrateLens(const Board& board, const std::vector<Corners>& views,
                              const std::array<int, 2>& size) {
  if (views.size() < 2) throw std::runtime_error("fewer than two pictures define no lens");
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
    throw std::runtime_error("the pictures define no lens: the board stands too much alike in all");
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
  if (*worst <= std::max(kTimesMedian * Median(misses), pixels)) return std::nullopt;
  return static_cast<std::size_t>(worst - misses.begin());
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace palpate
