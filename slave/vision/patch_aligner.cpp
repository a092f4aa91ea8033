#include "slave/vision/patch_aligner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "shared/text/text.h"
#include "slave/statistics/robust.h"
#include "slave/vision/grey.h"

namespace palpate {
namespace {

// Smallest rms change of a window's levels per pixel of shift, in any direction, for a unique
// position; below it noise (2 of 255) dominates.
constexpr double kMinSlope = 1.0;    // [levels/px]
constexpr double kMinAffine = 1e-4;  // smallest ratio of the affine Hessian's eigenvalues
// Smallest eigenvalue for the shift of a patch: a bar without marks has 1e-9, pure noise 1 [-].
// [tuned: AToolWithoutMarksIsTrackedByItsEnd]
constexpr double kMinShift = 1e-6;
// Width of the weights, in edges. [-] [tuned: WindowsThatLeaveTheImageAreLostAndComeBack]
constexpr double kSigma = 0.2;
// Factor from the residual to the noise that affects the position: linear interpolation reduces the
// variance of white noise in the residual to 4/9, but not its effect on the position, which
// Gaussian weights halve (sum w^2 / sum w = 1/2) [-]. [derived: these two factors]
constexpr double kNoiseOfResidual = 9.0 / 4 / 2;
constexpr int kMaxSteps = 30;
constexpr double kSettled = 0.003;  // [px]
constexpr double kFloor = 0.01;     // error of the interpolation [px]

// Limits of AlignRobustly: reach from the start, and last step with which it counts as converged
// [px].
constexpr double kAlignReach = 3, kEnough = 0.05;
constexpr float kMinError = 1.5F;  // scale of the errors below which no pixel is excluded [levels]
constexpr float kHidden = 0.3F;    // weight below which a pixel counts as covered

// Reads the levels of `size` pixels under `warp`, which are all inside the image, minus `mean`. It
// uses 16.16 fixed point along a row: accurate to 1e-5 px without conversions per pixel. The clamp
// limits outward rounding by one unit.
template <typename Pixel>
void SampleAs(const cv::Mat& grey, const PatchWarp& warp, const cv::Size& size, float mean,
              float* out) noexcept {
  constexpr int kFractionBits = 16;
  constexpr double kOne = 1 << kFractionBits;  // [by definition]
  const auto* pixels = grey.ptr<Pixel>();
  const auto stride = static_cast<std::ptrdiff_t>(grey.step1());
  const auto fixed = [](double px) { return static_cast<std::int32_t>(std::lround(px * kOne)); };
  const auto part = [](std::int32_t px) {
    return static_cast<float>(px & 0xffff) * static_cast<float>(1 / kOne);
  };
  const std::int32_t dx = fixed(warp.A(0, 0)), dy = fixed(warp.A(1, 0));
  const bool is_row = dx == fixed(1) && dy == 0;  // a pixel of the patch is one of the image
  const std::int32_t x_end = fixed(grey.cols - 1) - 1, y_end = fixed(grey.rows - 1) - 1;
  const Eigen::Vector2d half = 0.5 * Eigen::Vector2d(size.width - 1, size.height - 1);
  for (int v = 0; v < size.height; ++v) {
    const Eigen::Vector2d begin = warp.p + warp.A * Eigen::Vector2d(-half.x(), v - half.y());
    std::int32_t x = fixed(begin.x()), y = fixed(begin.y());
    if (is_row && x >= 0 && y >= 0 && x + (size.width - 1) * dx <= x_end && y <= y_end) {
      const Pixel* at = pixels + (y >> kFractionBits) * stride + (x >> kFractionBits);
      const float right = part(x), down = part(y);
      for (int u = 0; u < size.width; ++u) out[u] = Bilinear(at + u, stride, right, down) - mean;
      out += size.width;
      continue;
    }
    for (int u = 0; u < size.width; ++u, x += dx, y += dy) {
      const std::int32_t cx = std::clamp(x, 0, x_end), cy = std::clamp(y, 0, y_end);
      const Pixel* at = pixels + (cy >> kFractionBits) * stride + (cx >> kFractionBits);
      *out++ = Bilinear(at, stride, part(cx), part(cy)) - mean;
    }
  }
}

}  // namespace

// Weighted sums over the image under the patch.
struct PatchAligner::Sums {
  Eigen::Matrix<double, kMaxFreedoms + 1, 1> on_basis;
  double contrast = 0;
};

PatchAligner::PatchAligner(int edge)
    : size_(edge, edge), count_(std::ptrdiff_t{edge} * edge), min_slope_(kMinSlope) {
  Require(edge >= 5 && edge <= 255 && edge % 2 == 1, "window", edge, "an odd number from 5 to 255",
          " px");
  root_weights_.resize(count_);
  const int half = edge / 2;
  const double sigma = kSigma * edge;
  for (int v = -half; v <= half; ++v) {
    for (int u = -half; u <= half; ++u) {
      root_weights_((v + half) * std::ptrdiff_t{edge} + u + half) =
          static_cast<float>(std::exp(-(u * u + v * v) / (4 * sigma * sigma)));
    }
  }
  Allocate();
}

PatchAligner::PatchAligner(const cv::Size& size, const std::vector<float>& weights)
    : size_(size), count_(size.area()) {
  root_weights_ = Eigen::Map<const Eigen::VectorXf>(weights.data(), count_);
  Allocate();
  errors_.resize(count_);
  trust_.resize(count_);
  trusted_.resize(count_, 4);
  sizes_.resize(weights.size());
}

void PatchAligner::Allocate() {
  basis_.resize(count_, kMaxFreedoms + 2);
  levels_.resize((size_.width + 2) * (size_.height + 2));
  weight_ = root_weights_.squaredNorm();
}

// The image of a rectangle is a parallelogram: its corners determine whether all is inside.
bool PatchAligner::Sample(const cv::Mat& grey, const PatchWarp& warp, int ring) noexcept {
  const cv::Size size(size_.width + 2 * ring, size_.height + 2 * ring);
  const Eigen::Vector2d reach =
      warp.A.cwiseAbs() * 0.5 * Eigen::Vector2d(size.width - 1, size.height - 1);
  const Eigen::Vector2d low = warp.p - reach, high = warp.p + reach;
  if (!(low.x() >= 0 && low.y() >= 0 && high.x() <= grey.cols - 1 && high.y() <= grey.rows - 1)) {
    return false;  // so written, NaN is refused too
  }
  if (grey.type() == CV_8UC1) {
    SampleAs<std::uint8_t>(grey, warp, size, mean_, levels_.data());
  } else {
    SampleAs<std::int16_t>(grey, warp, size, mean_, levels_.data());
  }
  return true;
}

bool PatchAligner::Cut(const cv::Mat& grey, const PatchWarp& warp, Freedom freedom) noexcept {
  textured_ = affine_ = false;
  mean_ = 0;
  if (!(weight_ > 0) || !Sample(grey, warp, 1)) return false;
  const bool affine = freedom == Freedom::kAffine;
  FillBasis(affine);
  contrast_ = basis_.col(kMaxFreedoms).squaredNorm();
  if (!(contrast_ > 0)) return false;
  const int freedoms = affine ? kMaxFreedoms : 2;
  for (int k = 0; k < freedoms; ++k) {
    auto g = basis_.col(k);
    const float along = g.dot(basis_.col(kMaxFreedoms)) / static_cast<float>(contrast_);
    const float level = g.dot(root_weights_) / static_cast<float>(weight_);
    g -= level * root_weights_ + along * basis_.col(kMaxFreedoms);
  }
  return Invert(freedoms);
}

// Fills the columns listed in the header, multiplied by the square roots of the weights.
void PatchAligner::FillBasis(bool affine) noexcept {
  const int wide = size_.width + 2, half = size_.width / 2;
  for (int v = 0; v < size_.height; ++v) {
    for (int u = 0; u < size_.width; ++u) {
      const float* at = levels_.data() + (v + 1) * wide + u + 1;
      const auto i = std::ptrdiff_t{v} * size_.width + u;
      const float root = 0.5F * root_weights_(i);
      const float gx = root * (at[1] - at[-1]), gy = root * (at[wide] - at[-wide]);
      basis_(i, 0) = gx;
      basis_(i, 1) = gy;
      if (affine) {  // in half edges, so that all columns have the same magnitude
        const float x = static_cast<float>(u - half) / static_cast<float>(half);
        const float y = static_cast<float>(v - half) / static_cast<float>(half);
        basis_.row(i).segment<4>(2) << gx * x, gx * y, gy * x, gy * y;
      }
      basis_(i, kMaxFreedoms) = root_weights_(i) * *at;
    }
  }
  mean_ = basis_.col(kMaxFreedoms).dot(root_weights_) / static_cast<float>(weight_);
  basis_.col(kMaxFreedoms) -= mean_ * root_weights_;
  basis_.col(kMaxFreedoms + 1) = root_weights_;
}

bool PatchAligner::Invert(int freedoms) noexcept {
  Eigen::Matrix<double, kMaxFreedoms, kMaxFreedoms> H =
      Eigen::Matrix<double, kMaxFreedoms, kMaxFreedoms>::Zero();
  for (int k = 0; k < freedoms; ++k) {
    for (int l = 0; l <= k; ++l) H(k, l) = H(l, k) = basis_.col(k).dot(basis_.col(l));
  }
  information_ = H.topLeftCorner<2, 2>();
  const double mean_slope = information_.trace() / 2, determinant = information_.determinant();
  const double least = mean_slope - std::sqrt(std::max(0.0, mean_slope * mean_slope - determinant));
  textured_ = least > min_slope_ * min_slope_ * weight_ &&
              determinant > kMinShift * 4 * mean_slope * mean_slope;
  if (!textured_) return false;
  shift_inverse_ = information_.inverse();
  if (freedoms == kMaxFreedoms) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kMaxFreedoms, kMaxFreedoms>> eigen(
        H, Eigen::EigenvaluesOnly);
    affine_ = eigen.eigenvalues()(0) > kMinAffine * eigen.eigenvalues()(kMaxFreedoms - 1);
    if (affine_)
      affine_inverse_ =
          H.ldlt().solve(Eigen::Matrix<double, kMaxFreedoms, kMaxFreedoms>::Identity());
  }
  return true;
}

// Computes the levels times the roots of the weights, without their weighted mean.
double PatchAligner::WeighLevels() noexcept {
  auto levels = levels_.head(count_);
  levels.array() *= root_weights_.array();
  const double sum = root_weights_.dot(levels);
  return levels.squaredNorm() - sum * sum / weight_;
}

PatchAligner::Sums PatchAligner::Project(bool affine) noexcept {
  Sums sums;
  sums.contrast = WeighLevels();
  sums.on_basis.setZero();
  const auto levels = levels_.head(count_);
  for (int k = 0; k <= kMaxFreedoms; ++k) {
    const bool used = k < 2 || k == kMaxFreedoms || affine;
    if (used) sums.on_basis(k) = basis_.col(k).dot(levels);
  }
  return sums;
}

double PatchAligner::Score(const cv::Mat& grey, const PatchWarp& warp) noexcept {
  if (!textured_ || !Sample(grey, warp, 0)) return -1;
  const double contrast = WeighLevels();
  if (!(contrast > weight_)) return -1;
  return basis_.col(kMaxFreedoms).dot(levels_.head(count_)) / std::sqrt(contrast_ * contrast);
}

PatchAligner::Match PatchAligner::Align(const cv::Mat& grey, const PatchWarp& start,
                                        Freedom freedom) noexcept {
  Match match;
  match.warp = start;
  if (!textured_) return match;
  const bool affine = freedom == Freedom::kAffine && affine_;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (!Sample(grey, match.warp, 0)) return match;
    const Sums sums = Project(affine);
    const double gain = sums.on_basis(kMaxFreedoms) / contrast_;
    if (!(gain > 0.1 && gain < 10) || !(sums.contrast > 0)) return match;
    match.correlation = sums.on_basis(kMaxFreedoms) / std::sqrt(contrast_ * sums.contrast);

    Eigen::Matrix<double, kMaxFreedoms, 1> delta = Eigen::Matrix<double, kMaxFreedoms, 1>::Zero();
    if (affine) {
      delta = affine_inverse_ * sums.on_basis.head<kMaxFreedoms>() / gain;
    } else {
      delta.head<2>() = shift_inverse_ * sums.on_basis.head<2>() / gain;
    }
    Update(delta, &match.warp);
    const double area = match.warp.A.determinant();
    const bool is_near = (match.warp.p - start.p).norm() < size_.width / 2;
    if (!(area > 0.25 && area < 4) || !is_near) return match;
    if (delta.cwiseAbs().maxCoeff() < kSettled) {
      Conclude(sums, affine, &match);
      return match;
    }
  }
  return match;
}

// Updates the warp by the inverse of the template's motion.
void PatchAligner::Update(const Eigen::Matrix<double, kMaxFreedoms, 1>& delta,
                          PatchWarp* warp) const noexcept {
  const int half = size_.width / 2;
  Eigen::Matrix2d turn;  // I + D
  turn << 1 + delta(2) / half, delta(3) / half, delta(4) / half, 1 + delta(5) / half;
  warp->A = warp->A * turn.inverse();
  warp->p -= warp->A * delta.head<2>();
}

void PatchAligner::Conclude(const Sums& sums, bool affine, Match* match) const noexcept {
  const double gain = sums.on_basis(kMaxFreedoms) / contrast_;
  const double left = std::max(0.0, 1 - match->correlation * match->correlation);
  const double variance = kNoiseOfResidual * sums.contrast * left / weight_ / (gain * gain);
  const Eigen::Matrix2d inverse =
      affine ? Eigen::Matrix2d(affine_inverse_.topLeftCorner<2, 2>()) : shift_inverse_;
  match->covariance = variance * match->warp.A * inverse * match->warp.A.transpose() +
                      kFloor * kFloor * Eigen::Matrix2d::Identity();
  match->converged = match->covariance.allFinite();
}

PatchAligner::Match PatchAligner::AlignRobustly(const cv::Mat& grey, const PatchWarp& start,
                                                std::span<const float> trust) noexcept {
  Match match;
  match.warp = start;
  if (!textured_) return match;
  if (trust.empty()) {
    trust_.setOnes();
  } else {
    trust_ = Eigen::Map<const Eigen::VectorXf>(trust.data(), count_);
  }
  Fit fit;
  Eigen::Matrix4d inverse;
  double last = 1;
  for (int step = 1; step <= kMaxSteps && last > kSettled; ++step) {
    const bool is_near = (match.warp.p - start.p).cwiseAbs().maxCoeff() <= kAlignReach;
    if (!is_near || !Sample(grey, match.warp, 0)) return match;
    WeighLevels();
    fit = Regress(&inverse);
    if (!(fit(2) > 0)) return match;  // false for NaN
    Reweigh(fit);
    const Eigen::Vector2d move = fit.head<2>() / fit(2);
    match.warp.p -= match.warp.A * move.cwiseMax(-1).cwiseMin(1);
    last = step == 1 ? 1 : move.cwiseAbs().maxCoeff();  // the first step has no weights yet
  }
  match.converged = last < kEnough;
  Assess(fit, inverse, &match);
  return match;
}

// Fits the levels by the gradients of the shift, T~ and 1, with weights `trust`.
PatchAligner::Fit PatchAligner::Regress(Eigen::Matrix4d* inverse) noexcept {
  constexpr std::array kColumns{0, 1, kMaxFreedoms, kMaxFreedoms + 1};  // [by definition]
  Eigen::Matrix4d A;
  Eigen::Vector4d b;
  for (int k = 0; k < 4; ++k) {
    trusted_.col(k) = trust_.cwiseProduct(basis_.col(kColumns[static_cast<std::size_t>(k)]));
    for (int l = 0; l <= k; ++l) {
      A(k, l) = A(l, k) = trusted_.col(k).dot(basis_.col(kColumns[static_cast<std::size_t>(l)]));
    }
    b(k) = trusted_.col(k).dot(levels_.head(count_));
  }
  *inverse = A.ldlt().solve(Eigen::Matrix4d::Identity());
  return *inverse * b;
}

// Sets Tukey weights for the residuals of `fit`, scaled by their median.
void PatchAligner::Reweigh(const Fit& fit) noexcept {
  const Eigen::Vector4f f = fit.cast<float>();
  errors_ = levels_.head(count_) - f(0) * basis_.col(0) - f(1) * basis_.col(1) -
            f(2) * basis_.col(kMaxFreedoms) - f(3) * root_weights_;
  std::size_t used = 0;
  for (Eigen::Index i = 0; i < count_; ++i) {
    if (root_weights_(i) > 0) sizes_[used++] = std::abs(errors_(i));
  }
  const float scale = static_cast<float>(kSigmaPerMedian) * MedianOf(std::span(sizes_).first(used));
  const float cut = static_cast<float>(kBiweightCut) * std::max(scale, kMinError);
  trust_ = (1 - (errors_.array() / cut).square().min(1)).square().matrix();
}

// Computes the noise of the trusted pixels and the fraction of the others.
void PatchAligner::Assess(const Fit& fit, const Eigen::Matrix4d& inverse,
                          Match* match) const noexcept {
  double square = 0, used = 0, hidden = 0;
  for (Eigen::Index i = 0; i < count_; ++i) {
    if (root_weights_(i) == 0) continue;
    square += trust_(i) * errors_(i) * errors_(i);
    used += trust_(i);
    hidden += trust_(i) < kHidden ? 1 : 0;
  }
  match->covered = hidden / weight_;
  match->covariance =
      square / std::max(used, 1.0) / (fit(2) * fit(2)) * inverse.topLeftCorner<2, 2>();
}

}  // namespace palpate
