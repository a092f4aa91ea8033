#include "slave/vision/template_match.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "shared/statistics/robust.h"

namespace palpate {
namespace {

constexpr int kMaxSteps = 30;
constexpr double kSettled = 1e-3;  // [px]
constexpr double kReach = 1.5;     // farther from the start than this is another place [px]
constexpr double kRobustReach = 3;
constexpr int kRobustSteps = 20;
constexpr double kRobustSettled = 5e-3, kRobustEnough = 0.05;  // [px]
constexpr float kLeastError = 1.5F;  // scale of the errors below which none is left out [levels]
constexpr float kHidden = 0.3F;      // weight below which a pixel counts as covered

cv::Mat AsFloat(const GreyPatch& patch) {
  cv::Mat levels;
  cv::Mat(patch.height, patch.width, CV_16SC1, const_cast<std::int16_t*>(patch.levels.data()))
      .convertTo(levels, CV_32F);
  return levels;
}

}  // namespace

Ncc::Ncc(GreyPatch pattern) : pattern_(std::move(pattern)) {
  if (pattern_.levels.empty()) throw std::invalid_argument("the template is empty");
  levels_ = AsFloat(pattern_);
  mean_ = cv::mean(levels_)[0];
  for (const std::int16_t level : pattern_.levels) contrast_ += (level - mean_) * (level - mean_);
  if (!(VarianceOf(pattern_) > 0)) throw std::invalid_argument("the template has no contrast");
}

const ScoreMap& Ncc::Match(const GreyPatch& window) {
  map_.release();
  if (window.width < pattern_.width || window.height < pattern_.height) return map_;
  cv::matchTemplate(AsFloat(window), levels_, map_, cv::TM_CCOEFF_NORMED);
  return map_;
}

double Ncc::At(const GreyPatch& window, int x, int y) const {
  double sum = 0, square = 0, product = 0;
  for (int j = 0; j < pattern_.height; ++j) {
    const std::int16_t *T = pattern_.Row(j), *I = window.Row(y + j) + x;
    for (int i = 0; i < pattern_.width; ++i) {
      sum += I[i];
      square += I[i] * I[i];
      product += (T[i] - mean_) * I[i];
    }
  }
  const double contrast = square - sum * sum / static_cast<double>(pattern_.levels.size());
  return contrast > 0 ? product / std::sqrt(contrast_ * contrast) : 0;
}

TemplateAligner::TemplateAligner(const GreyPatch& pattern, std::span<const float> weights)
    : width_(pattern.width - 2), height_(pattern.height - 2) {
  if (width_ <= 0 || height_ <= 0) return;  // not determined
  const Eigen::Index size = static_cast<Eigen::Index>(width_) * height_;
  // Columns: g_x, g_y, T.
  Eigen::MatrixX3d raw(size, 3);
  Eigen::VectorXd w(size);
  for (int y = 0, k = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x, ++k) {
      raw(k, 0) = 0.5 * (pattern.At(x + 2, y + 1) - pattern.At(x, y + 1));
      raw(k, 1) = 0.5 * (pattern.At(x + 1, y + 2) - pattern.At(x + 1, y));
      raw(k, 2) = pattern.At(x + 1, y + 1);
      w(k) = weights[static_cast<std::size_t>((y + 1) * pattern.width + x + 1)];
    }
  }
  weight_ = w.sum();
  if (!(weight_ > 0)) return;
  const Eigen::RowVector3d means = (w.transpose() * raw) / weight_;
  raw.rowwise() -= means;
  mean_ = static_cast<float>(means(2));
  contrast_ = w.dot(raw.col(2).cwiseAbs2());
  if (!(contrast_ > 0)) return;
  const Eigen::MatrixX2d gradients = raw.leftCols<2>();
  for (int axis : {0, 1}) {
    raw.col(axis) -= raw.col(2) * (w.cwiseProduct(raw.col(2)).dot(raw.col(axis)) / contrast_);
  }
  const Eigen::MatrixX3d weighted = w.asDiagonal() * raw;
  information_ = raw.leftCols<2>().transpose() * weighted.leftCols<2>();
  const double det = information_.determinant();
  const double trace = information_.trace();
  determined_ = det > 1e-6 * trace * trace;
  if (determined_) covariance_ = information_.inverse();
  projections_ = weighted.cast<float>();
  basis_.resize(size, 4);
  basis_ << gradients.cast<float>(), raw.col(2).cast<float>(), Eigen::VectorXf::Ones(size);
  trust_.resize(size);
  errors_.resize(static_cast<std::size_t>(size));
  weights_ = w.cast<float>();
  levels_.resize(size);
}

void TemplateAligner::Interpolate(const GreyPatch& window, const Eigen::Vector2d& p) noexcept {
  const int left = static_cast<int>(std::floor(p.x()));
  const int top = static_cast<int>(std::floor(p.y()));
  const auto u = static_cast<float>(p.x() - left), v = static_cast<float>(p.y() - top);
  const float c00 = (1 - u) * (1 - v), c10 = u * (1 - v), c01 = (1 - u) * v, c11 = u * v;
  for (int y = 0; y < height_; ++y) {
    const std::int16_t* upper = window.Row(top + y + 1) + left + 1;
    const std::int16_t* lower = upper + window.width;
    float* out = levels_.data() + static_cast<std::ptrdiff_t>(y) * width_;
    for (int x = 0; x < width_; ++x) {
      out[x] = c00 * upper[x] + c10 * upper[x + 1] + c01 * lower[x] + c11 * lower[x + 1] - mean_;
    }
  }
}

bool TemplateAligner::IsInside(const GreyPatch& window, const Eigen::Vector2d& p) const noexcept {
  const Eigen::Vector2d last(window.width - width_ - 3, window.height - height_ - 3);
  return (p.array() >= 0).all() && (p - last).maxCoeff() <= 0;
}

TemplateAligner::Result TemplateAligner::Align(const GreyPatch& window,
                                               const Eigen::Vector2d& start) noexcept {
  Result result;
  result.p = start;
  if (!determined_) return result;
  double gain = 0;
  for (int step = 0; step < kMaxSteps && !result.converged; ++step) {
    const bool near = (result.p - start).cwiseAbs().maxCoeff() <= kReach;
    if (!near || !IsInside(window, result.p)) return {false, start, 0, 0};
    Interpolate(window, result.p);
    const Eigen::Vector3d sums = (levels_.transpose() * projections_).transpose().cast<double>();
    gain = sums(2) / contrast_;
    if (!(gain > 0)) return {false, start, 0, 0};
    const Eigen::Vector2d move = covariance_ * sums.head<2>() / gain;
    result.p -= move;
    result.converged = move.cwiseAbs().maxCoeff() < kSettled;
  }
  const double sum = levels_.dot(weights_);
  const double square = levels_.cwiseAbs2().dot(weights_);
  const double residual = square - sum * sum / weight_ - gain * gain * contrast_;
  const double noise2 = std::max(residual, 0.0) / std::max(weight_ - 4, 1.0);
  result.sigma = std::sqrt(noise2 * covariance_.diagonal().maxCoeff()) / gain;
  return result;
}

// Tukey's weights of the errors that `fit` leaves, on the scale of their median.
void TemplateAligner::Reweigh(const Fit& fit) noexcept {
  const Eigen::Vector4f coefficients = fit.cast<float>();
  std::size_t used = 0;
  for (Eigen::Index i = 0; i < trust_.size(); ++i) {
    trust_(i) = std::abs(levels_(i) - basis_.row(i).dot(coefficients));
    if (weights_(i) > 0) errors_[used++] = trust_(i);
  }
  const float middle = MedianOf(std::span(errors_).first(used));
  const float cut = static_cast<float>(kBiweightCut) *
                    std::max(static_cast<float>(kSigmaPerMedian) * middle, kLeastError);
  for (Eigen::Index i = 0; i < trust_.size(); ++i) {
    const float u = std::min(trust_(i) / cut, 1.0F);
    trust_(i) = weights_(i) * (1 - u * u) * (1 - u * u);
  }
}

// The picture's levels as a sum of g_x, g_y, T~ and 1, by squares weighted with the trust.
TemplateAligner::Fit TemplateAligner::Regress() noexcept {
  Eigen::Matrix4f A = Eigen::Matrix4f::Zero();
  Eigen::Vector4f b = Eigen::Vector4f::Zero();
  for (Eigen::Index i = 0; i < trust_.size(); ++i) {
    if (trust_(i) == 0) continue;
    const Eigen::Vector4f row = basis_.row(i);
    A += trust_(i) * row * row.transpose();
    b += trust_(i) * levels_(i) * row;
  }
  const Eigen::LDLT<Eigen::Matrix4d> solver(A.cast<double>());
  variances_ = solver.solve(Eigen::Matrix4d::Identity()).diagonal();
  return solver.solve(b.cast<double>());
}

// How well `fit` fits: noise of the pixels it trusts, and how many it does not.
void TemplateAligner::Assess(const Fit& fit, Result& result) const noexcept {
  const Eigen::Vector4f coefficients = fit.cast<float>();
  double square = 0, used = 0, hidden = 0, all = 0;
  for (Eigen::Index i = 0; i < trust_.size(); ++i) {
    if (weights_(i) == 0) continue;
    const double error = levels_(i) - basis_.row(i).dot(coefficients);
    square += trust_(i) * error * error;
    used += trust_(i);
    hidden += trust_(i) < kHidden * weights_(i) ? 1 : 0;
    all += 1;
  }
  result.covered = hidden / std::max(all, 1.0);
  result.sigma = std::sqrt(square / std::max(used, 1.0) * variances_.head<2>().maxCoeff()) / fit(2);
}

TemplateAligner::Result TemplateAligner::AlignAround(const GreyPatch& window,
                                                     const Eigen::Vector2d& start,
                                                     std::span<const float> trust) noexcept {
  Result result{false, start, 0, 0};
  if (!determined_) return result;
  for (int y = 0, k = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x, ++k) {
      const auto at = static_cast<std::size_t>((y + 1) * (width_ + 2) + x + 1);
      trust_(k) = trust.empty() ? weights_(k) : weights_(k) * trust[at];
    }
  }
  Fit fit = Fit::Zero();
  double last = kRobustReach;
  for (int step = 0; step < kRobustSteps && last > kRobustSettled; ++step) {
    const bool near = (result.p - start).cwiseAbs().maxCoeff() <= kRobustReach;
    if (!near || !IsInside(window, result.p)) return {false, start, 0, 0};
    Interpolate(window, result.p);
    fit = Regress();
    if (!(fit(2) > 0)) return {false, start, 0, 0};  // false for NaN
    Reweigh(fit);
    const Eigen::Vector2d move = fit.head<2>() / fit(2);
    result.p -= move.cwiseMax(-1).cwiseMin(1);
    last = std::max(move.cwiseAbs().maxCoeff(), step < 3 ? 1.0 : 0.0);
  }
  result.converged = last < kRobustEnough;
  Assess(fit, result);
  return result;
}

}  // namespace palpate
