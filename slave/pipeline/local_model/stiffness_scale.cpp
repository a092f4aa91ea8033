#include "slave/pipeline/local_model/stiffness_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace palpate {
namespace {

// Ratio of a force to its sigma from which on it is significant. [-] [tuned:
// OnlyFiniteForcesAboveZeroTell]
constexpr double kErrors = 3;
constexpr double kMinRatio = 0.25,
                 kMaxRatio = 4;  // [-] [tuned: OnlyFiniteForcesAboveZeroTell]
// Distance at which the correlation of values falls to 1 / e [-]. [tuned:
// DepthsNotEstimatedFollowTheirNeighbours]
constexpr double kAlike = 5;
constexpr double kForgotten = 2e-3;  // share per sample

}  // namespace

RatioSample CompareForces(double estimate, double sigma, double modelled) noexcept {
  const bool known = std::isfinite(estimate) && std::isfinite(sigma) && std::isfinite(modelled);
  if (!known || !(estimate > 0) || !(modelled > 0)) return {};
  return {std::clamp(estimate / modelled, kMinRatio, kMaxRatio), kErrors * sigma / estimate, true};
}

double LearningRate(double time, double rate) {
  return 1 - std::exp(-1 / (time * rate));
}

StiffnessScale::StiffnessScale(double full_depth, double learning_rate, double spread) noexcept
    : full_depth_(full_depth), learning_rate_(learning_rate) {
  for (int i = 0; i < kDepths; ++i) {
    for (int j = 0; j < kDepths; ++j) {
      before_(i, j) = spread * spread * std::exp(-std::abs(i - j) / kAlike);
    }
  }
  Forget();
}

void StiffnessScale::Forget() noexcept {
  ratios_.setOnes();
  covariance_ = before_;
}

StiffnessScale::Values StiffnessScale::Weights(double depth) const noexcept {
  const double at = std::clamp(depth / full_depth_, 0.0, 1.0) * (kDepths - 1);
  const int below = std::min(static_cast<int>(at), kDepths - 2);
  Values weights = Values::Zero();
  weights[below + 1] = at - below;
  weights[below] = 1 - weights[below + 1];
  return weights;
}

void StiffnessScale::Learn(double depth, const RatioSample& sample) noexcept {
  if (!sample.is_informative || !std::isfinite(depth) || !std::isfinite(sample.error)) return;
  const Values weights = Weights(depth);
  const Values mixed = covariance_ * weights;
  const double variance = weights.dot(mixed);
  // A ratio of four is an outlier relative to the expected spread, so only the learning rate limits
  // its influence.
  const double error =
      std::max(sample.error * sample.error, variance * (1 - learning_rate_) / learning_rate_);
  const Values gain = mixed / (variance + error);
  ratios_ += gain * (sample.ratio - weights.dot(ratios_));
  ratios_ = ratios_.cwiseMax(kMinRatio).cwiseMin(kMaxRatio);
  covariance_ -= gain * mixed.transpose();
  covariance_ += kForgotten * (before_ - covariance_);
}

StiffnessScale::Press StiffnessScale::Scaled(const Press& modelled, double depth) const noexcept {
  const Value estimated_by_modelled = At(depth);
  const double stiffness = modelled.stiffness * estimated_by_modelled.ratio;
  const double bent = stiffness + modelled.force * estimated_by_modelled.slope;
  return {modelled.force * estimated_by_modelled.ratio, std::max(bent, stiffness / 2)};
}

StiffnessScale::Value StiffnessScale::At(double depth) const noexcept {
  Value value{Weights(depth).dot(ratios_), 0};
  if (depth > 0 && depth < full_depth_) {
    const int below = std::min(static_cast<int>(depth / full_depth_ * (kDepths - 1)), kDepths - 2);
    value.slope = (ratios_[below + 1] - ratios_[below]) * (kDepths - 1) / full_depth_;
  }
  return value;
}

}  // namespace palpate
