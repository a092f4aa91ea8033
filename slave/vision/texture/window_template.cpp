#include "slave/vision/texture/window_template.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kSmallest = 32;  // [px] [tuned: TheOtherCamerasPictureMayBeLarger]

// BT.601 in 16.16 fixed point.
void GreyRow(const std::uint8_t* bgr, std::uint8_t* grey, int width) {
  for (int x = 0; x < width; ++x, bgr += 3) {
    grey[x] = static_cast<std::uint8_t>(
        (7471U * bgr[0] + 38470U * bgr[1] + 19595U * bgr[2] + 32768U) >> 16);
  }
}

// Mean of 2 x 2; an odd last row or column is left out.
void Halve(const cv::Mat& from, cv::Mat& to) {
  for (int y = 0; y < to.rows; ++y) {
    const auto *a = from.ptr<std::uint8_t>(2 * y), *b = from.ptr<std::uint8_t>(2 * y + 1);
    auto* out = to.ptr<std::uint8_t>(y);
    for (int x = 0; x < to.cols; ++x) {
      out[x] =
          static_cast<std::uint8_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2U) >> 2);
    }
  }
}

// A window has a place where a shift of a pixel, in whatever direction, changes its levels by this
// much root mean square: below it the camera's noise (2 of 255) has the say.
constexpr double kLeastSlope = 1.0;    // [levels/px]
constexpr double kLeastAffine = 1e-4;  // of the affine Hessian's eigenvalues, least to largest
// Of the weights, in edges. [-] [tuned: WindowsThatLeaveThePictureAreLostAndComeBack]
constexpr double kSigma = 0.2;
// White noise, linearly interpolated, loses all but 4/9 of its variance in the residual (the mean
// over a pixel's parts) though not of its effect on the place, where a Gaussian's weights halve it:
// sum w^2 / sum w = 1/2 [-]. [derived: these two factors]
constexpr double kNoiseOfResidual = 9.0 / 4 / 2;
constexpr int kMostSteps = 30;
constexpr double kSettled = 0.003;  // [px]
constexpr double kFloor = 0.01;     // what interpolation leaves [px]

}  // namespace

PicturePyramid::PicturePyramid(const cv::Mat& first, int levels) : type_(first.type()) {
  if (first.dims != 2 || (type_ != CV_8UC1 && type_ != CV_8UC3)) {
    throw std::invalid_argument("image of texture: accepted is 8 bit grey or BGR");
  }
  if (first.cols < kSmallest || first.rows < kSmallest) {
    throw std::invalid_argument("image of texture: " + std::to_string(first.cols) + " x " +
                                std::to_string(first.rows) + " px: accepted is 32 px and more");
  }
  Require(levels >= 1, "levels", levels, ">= 1");
  for (cv::Size size = first.size();
       static_cast<int>(levels_.size()) < levels && std::min(size.width, size.height) >= kSmallest;
       size = {size.width / 2, size.height / 2}) {
    levels_.emplace_back(size, CV_8UC1);
  }
  Read(first);
}

bool PicturePyramid::Read(const cv::Mat& picture) noexcept {
  cv::Mat& fine = levels_.front();
  if (picture.dims != 2 || picture.type() != type_ || picture.data == nullptr ||
      picture.cols != fine.cols || picture.rows != fine.rows) {
    return false;
  }
  for (int y = 0; y < fine.rows; ++y) {
    if (type_ == CV_8UC3) {
      GreyRow(picture.ptr<std::uint8_t>(y), fine.ptr<std::uint8_t>(y), fine.cols);
    } else {
      std::memcpy(fine.ptr(y), picture.ptr(y), static_cast<std::size_t>(fine.cols));
    }
  }
  for (std::size_t l = 1; l < levels_.size(); ++l) Halve(levels_[l - 1], levels_[l]);
  return true;
}

std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& picture, int count, int edge,
                                           double apart) {
  const bool readable =
      picture.dims == 2 && (picture.type() == CV_8UC1 || picture.type() == CV_8UC3);
  const int rim = edge / 2 + 2;
  if (!readable || count < 1 || edge < 1 || picture.cols <= 2 * rim || picture.rows <= 2 * rim) {
    return {};
  }
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::Mat inside = cv::Mat::zeros(grey.size(), CV_8UC1);
  inside(cv::Rect(rim, rim, grey.cols - 2 * rim, grey.rows - 2 * rim)).setTo(255);
  constexpr double kOfTheBest = 0.01;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, count, kOfTheBest, apart, inside, edge);
  std::vector<Eigen::Vector2d> centres;
  centres.reserve(corners.size());
  for (const cv::Point2f& corner : corners) centres.emplace_back(corner.x, corner.y);
  return centres;
}

// Weighted, of the picture under the window.
struct WindowTemplate::Sums {
  Eigen::Matrix<double, kMost + 1, 1> on_basis;
  double contrast = 0;
};

WindowTemplate::WindowTemplate(int edge) : edge_(edge), count_(std::ptrdiff_t{edge} * edge) {
  Require(edge >= 5 && edge <= 255 && edge % 2 == 1, "window", edge, "an odd number from 5 to 255",
          " px");
  basis_.resize(count_, kMost + 1);
  levels_.resize(std::ptrdiff_t{edge + 2} * (edge + 2));
  root_weights_.resize(count_);
  const int half = edge / 2;
  const double sigma = kSigma * edge;
  for (int v = -half; v <= half; ++v) {
    for (int u = -half; u <= half; ++u) {
      root_weights_((v + half) * std::ptrdiff_t{edge} + u + half) =
          static_cast<float>(std::exp(-(u * u + v * v) / (4 * sigma * sigma)));
    }
  }
  weight_ = root_weights_.squaredNorm();
}

// Bilinear. The picture of a square is a parallelogram: its corners say whether all is inside.
bool WindowTemplate::Sample(const cv::Mat& grey, const WindowWarp& warp, int ring) noexcept {
  const int half = edge_ / 2 + ring;
  const Eigen::Vector2d reach = warp.A.cwiseAbs() * Eigen::Vector2d(half, half);
  const Eigen::Vector2d low = warp.p - reach, high = warp.p + reach;
  if (!(low.x() >= 0 && low.y() >= 0 && high.x() < grey.cols - 1 && high.y() < grey.rows - 1)) {
    return false;  // so written, NaN is refused too
  }
  const auto* pixels = grey.ptr<std::uint8_t>();
  const auto stride = static_cast<std::ptrdiff_t>(grey.step[0]);
  // 16.16 fixed point along a row: 1e-5 px, and no conversions per pixel. Rounding outwards by a
  // unit is caught by the clamp. [-] [tuned: ChosenWindowsHaveTextureLieApartAndInside]
  constexpr double kOne = 65536;
  const auto dx = static_cast<std::int32_t>(std::lround(warp.A(0, 0) * kOne));
  const auto dy = static_cast<std::int32_t>(std::lround(warp.A(1, 0) * kOne));
  const std::int32_t x_end = (grey.cols - 1) * 65536 - 1, y_end = (grey.rows - 1) * 65536 - 1;
  float* out = levels_.data();
  for (int v = -half; v <= half; ++v) {
    const Eigen::Vector2d begin = warp.p + warp.A * Eigen::Vector2d(-half, v);
    auto x = static_cast<std::int32_t>(std::lround(begin.x() * kOne));
    auto y = static_cast<std::int32_t>(std::lround(begin.y() * kOne));
    for (int u = -half; u <= half; ++u, x += dx, y += dy) {
      const std::int32_t cx = std::clamp(x, 0, x_end), cy = std::clamp(y, 0, y_end);
      const std::uint8_t* at = pixels + (cy >> 16) * stride + (cx >> 16);
      const float fx = static_cast<float>(cx & 0xffff) * static_cast<float>(1 / kOne);
      const float fy = static_cast<float>(cy & 0xffff) * static_cast<float>(1 / kOne);
      const float a = static_cast<float>(at[0]), b = static_cast<float>(at[1]);
      const float c = static_cast<float>(at[stride]), d = static_cast<float>(at[stride + 1]);
      const float above = a + fx * (b - a), below = c + fx * (d - c);
      *out++ = above + fy * (below - above) - mean_;
    }
  }
  return true;
}

bool WindowTemplate::Cut(const cv::Mat& grey, const WindowWarp& warp, Freedom freedom) noexcept {
  textured_ = affine_ = false;
  mean_ = 0;
  if (!Sample(grey, warp, 1)) return false;
  const bool affine = freedom == Freedom::kAffine;
  FillBasis(affine);
  contrast_ = basis_.col(kMost).squaredNorm();
  if (!(contrast_ > weight_)) return false;  // less than a level
  const int freedoms = affine ? kMost : 2;
  for (int k = 0; k < freedoms; ++k) {
    auto g = basis_.col(k);
    const float along = g.dot(basis_.col(kMost)) / static_cast<float>(contrast_);
    const float level = g.dot(root_weights_) / static_cast<float>(weight_);
    g -= level * root_weights_ + along * basis_.col(kMost);
  }
  return Invert(freedoms);
}

// Columns as in the header, each times the roots of the weights.
void WindowTemplate::FillBasis(bool affine) noexcept {
  const int wide = edge_ + 2, half = edge_ / 2;
  for (int v = 0; v < edge_; ++v) {
    for (int u = 0; u < edge_; ++u) {
      const float* at = levels_.data() + (v + 1) * wide + u + 1;
      const auto i = std::ptrdiff_t{v} * edge_ + u;
      const float root = 0.5F * root_weights_(i);
      const float gx = root * (at[1] - at[-1]), gy = root * (at[wide] - at[-wide]);
      basis_(i, 0) = gx;
      basis_(i, 1) = gy;
      if (affine) {  // in half edges, so that all columns are of one size
        const float x = static_cast<float>(u - half) / static_cast<float>(half);
        const float y = static_cast<float>(v - half) / static_cast<float>(half);
        basis_.row(i).segment<4>(2) << gx * x, gx * y, gy * x, gy * y;
      }
      basis_(i, kMost) = root_weights_(i) * *at;
    }
  }
  mean_ = basis_.col(kMost).dot(root_weights_) / static_cast<float>(weight_);
  basis_.col(kMost) -= mean_ * root_weights_;
}

bool WindowTemplate::Invert(int freedoms) noexcept {
  Eigen::Matrix<double, kMost, kMost> H = Eigen::Matrix<double, kMost, kMost>::Zero();
  for (int k = 0; k < freedoms; ++k) {
    for (int l = 0; l <= k; ++l) H(k, l) = H(l, k) = basis_.col(k).dot(basis_.col(l));
  }
  const Eigen::Matrix2d shift = H.topLeftCorner<2, 2>();
  const double mean_slope = shift.trace() / 2, determinant = shift.determinant();
  const double least = mean_slope - std::sqrt(std::max(0.0, mean_slope * mean_slope - determinant));
  textured_ = least > kLeastSlope * kLeastSlope * weight_;
  if (!textured_) return false;
  shift_inverse_ = shift.inverse();
  if (freedoms == kMost) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kMost, kMost>> eigen(
        H, Eigen::EigenvaluesOnly);
    affine_ = eigen.eigenvalues()(0) > kLeastAffine * eigen.eigenvalues()(kMost - 1);
    if (affine_) affine_inverse_ = H.ldlt().solve(Eigen::Matrix<double, kMost, kMost>::Identity());
  }
  return true;
}

// Levels times the roots of the weights, and what is left of them beside the weighted mean.
double WindowTemplate::WeighLevels() noexcept {
  auto levels = levels_.head(count_);
  levels.array() *= root_weights_.array();
  const double sum = root_weights_.dot(levels);
  return levels.squaredNorm() - sum * sum / weight_;
}

WindowTemplate::Sums WindowTemplate::Project(bool affine) noexcept {
  Sums sums;
  sums.contrast = WeighLevels();
  sums.on_basis.setZero();
  const auto levels = levels_.head(count_);
  for (int k = 0; k <= kMost; ++k) {
    const bool used = k < 2 || k == kMost || affine;
    if (used) sums.on_basis(k) = basis_.col(k).dot(levels);
  }
  return sums;
}

double WindowTemplate::Score(const cv::Mat& grey, const WindowWarp& warp) noexcept {
  if (!textured_ || !Sample(grey, warp, 0)) return -1;
  const double contrast = WeighLevels();
  if (!(contrast > weight_)) return -1;
  return basis_.col(kMost).dot(levels_.head(count_)) / std::sqrt(contrast_ * contrast);
}

WindowTemplate::Match WindowTemplate::Align(const cv::Mat& grey, const WindowWarp& start,
                                            Freedom freedom) noexcept {
  Match match;
  match.warp = start;
  if (!textured_) return match;
  const bool affine = freedom == Freedom::kAffine && affine_;
  const double half = edge_ / 2;  // NOLINT(bugprone-integer-division): whole pixels are meant
  for (int step = 0; step < kMostSteps; ++step) {
    WindowWarp& warp = match.warp;
    if (!Sample(grey, warp, 0)) return match;
    const Sums sums = Project(affine);
    const double gain = sums.on_basis(kMost) / contrast_;
    if (!(gain > 0.1 && gain < 10) || !(sums.contrast > 0)) return match;
    match.correlation = sums.on_basis(kMost) / std::sqrt(contrast_ * sums.contrast);

    Eigen::Matrix<double, kMost, 1> delta = Eigen::Matrix<double, kMost, 1>::Zero();
    if (affine) {
      delta = affine_inverse_ * sums.on_basis.head<kMost>() / gain;
    } else {
      delta.head<2>() = shift_inverse_ * sums.on_basis.head<2>() / gain;
    }
    Eigen::Matrix2d turn;  // I + D
    turn << 1 + delta(2) / half, delta(3) / half, delta(4) / half, 1 + delta(5) / half;
    if (!(turn.determinant() > 0.2)) return match;
    warp.A = warp.A * turn.inverse();
    warp.p -= warp.A * delta.head<2>();
    const double area = warp.A.determinant();
    if (!(area > 0.25 && area < 4) || !((warp.p - start.p).norm() < half)) return match;
    if (delta.cwiseAbs().maxCoeff() < kSettled) {
      const double left = std::max(0.0, 1 - match.correlation * match.correlation);
      const double variance = kNoiseOfResidual * sums.contrast * left / weight_ / (gain * gain);
      const Eigen::Matrix2d inverse =
          affine ? Eigen::Matrix2d(affine_inverse_.topLeftCorner<2, 2>()) : shift_inverse_;
      match.covariance = variance * warp.A * inverse * warp.A.transpose() +
                         kFloor * kFloor * Eigen::Matrix2d::Identity();
      match.converged = match.covariance.allFinite();
      return match;
    }
  }
  return match;
}

}  // namespace palpate
