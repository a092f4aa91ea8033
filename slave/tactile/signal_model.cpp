#include "slave/tactile/signal_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

namespace palpate {
namespace {

using Signals = SignalPattern::Signals;
using Covariance = SignalPattern::Covariance;

// Largest deviation of an electrode from its prediction in standard deviations [-]. [tuned:
// SignalsThatChangeTogetherAreUnchanged]
constexpr double kOutlier = 5.5;
// Limit for an electrode whose reading is constant. [-] [tuned:
// AConstantElectrodeNeedsLessToBeWrong]
constexpr double kStillOutlier = 1.3;
// Typical signals in contact, for the choice between kinds of contacts [counts].
constexpr double kTypicalSize = 60;
// Smallest contact size, so that gentle contacts differ from noise [counts].
constexpr double kMinSize = 10;
// Multiple of the usual variance below which nothing is removed. [-] [tuned:
// ExcessNoiseIsSubtracted]
constexpr double kQuiet = 4;
constexpr double kSignificant = 3;  // standard deviations of a common drift [-]
constexpr int kMaxReplaced = 4;     // electrodes; with more the right ones are unknown

// Returns the signals of a drift of one count of all electrodes.
Signals Together() {
  Signals together = Signals::Ones();
  together[kElectrodeCount] = 0;
  return together;
}

double LogDeterminant(const Eigen::LLT<Covariance>& factor) {
  return 2 * factor.matrixLLT().diagonal().array().log().sum();
}

// Returns x' S⁻¹ x without the part of a single signal beyond kOutlier.
double RobustSquare(const Signals& x, const Covariance& inverse) {
  const Signals y = inverse * x;
  const double outlier = (y.cwiseAbs2().cwiseQuotient(inverse.diagonal())).maxCoeff();
  return x.dot(y) - std::max(0.0, outlier - kOutlier * kOutlier);
}

}  // namespace

SignalModel::SignalModel(const SignalPattern& pattern, double rate)
    : force_(pattern.force),
      noise_(rate),
      share_(1 - std::exp(-1 / (SignalNoise::kMeasuringTime * rate))) {
  for (const SignalPattern::Kind& kind : pattern.kinds) {
    Covariance S = kind.shape;
    S += (UsualNoise2() / (kTypicalSize * kTypicalSize)).asDiagonal();
    const Eigen::LLT<Covariance> factor(S);
    kinds_.push_back({kind.shape, -2 * std::log(kind.share), factor.solve(Covariance::Identity()),
                      LogDeterminant(factor)});
  }
  Reset();
}

void SignalModel::Reset() noexcept {
  noise_.Reset();
  drift2_ = drift_ = 0;
  jumps_.Reset();
  mahalanobis2_ = 1;
  pressure_residual_ = 0;
}

void SignalModel::Update(const TactileSignals& change, const Electrodes& is_dead,
                         const Electrodes& is_still, double baseline2,
                         const TactileSignals& baseline_drift) noexcept {
  const Signals all = PatternSignals(change), w = PatternSignals(baseline_drift);
  jumps_.Update(all, noise_.relative());
  Signals x = all, noise2 = noise_.variances();
  noise2.head<kElectrodeCount>().array() += baseline2;
  replaced_ = 0;
  for (std::size_t i = 0; i < is_dead.size(); ++i) {
    is_wrong_[i] = is_dead[i] || jumps_.is_out(i);
    if (!is_wrong_[i]) continue;
    ++replaced_;
    x[static_cast<Eigen::Index>(i)] = 0;
    noise2[static_cast<Eigen::Index>(i)] = ElectrodeJumps::kUnknown2;
  }
  Covariance excess = drift2_ * Together() * Together().transpose() + w * w.transpose();
  Covariance other = excess;
  other += noise2.asDiagonal();
  const double size2 = std::max(x.squaredNorm() - UsualNoise2().sum(), kMinSize * kMinSize);
  Covariance inverse = ChooseKind(x, size2, other);
  ReplaceOutliers(x, is_still, &noise2, &inverse);
  noise_.Update(x, (inverse * x).cwiseQuotient(inverse.diagonal()), jumps_.calm());
  TrackDrift(x, inverse, w);
  jumps_.Reinstate(all, x, inverse);
  excess += (noise2 - kQuiet * UsualNoise2()).cwiseMax(0).asDiagonal();
  Correct(change, x, excess, inverse);
}

std::array<std::size_t, SignalModel::kCandidates> SignalModel::Candidates(
    const Signals& unit) const noexcept {
  std::array<std::size_t, kCandidates> best{};
  std::array<double, kCandidates> costs;
  costs.fill(std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    const Kind& kind = kinds_[k];
    double cost = RobustSquare(unit, kind.inverse) + kind.log_det + kind.offset;
    std::size_t index = k;
    for (std::size_t i = 0; i < kCandidates; ++i) {  // insertion sort, the smallest cost first
      if (!(cost < costs[i])) continue;
      std::swap(cost, costs[i]);
      std::swap(index, best[i]);
    }
  }
  return best;
}

Covariance SignalModel::ChooseKind(const Signals& x, double size2,
                                   const Covariance& other) noexcept {
  Covariance best = Covariance::Identity();
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t k : Candidates(x / std::sqrt(size2))) {
    const Eigen::LLT<Covariance> factor(size2 * kinds_[k].shape + other);
    const Covariance inverse = factor.solve(Covariance::Identity());
    const double cost = RobustSquare(x, inverse) + LogDeterminant(factor) + kinds_[k].offset;
    if (!(cost < least)) continue;
    least = cost;
    kind_ = k;
    best = inverse;
  }
  return best;
}

void SignalModel::ReplaceOutliers(const Signals& x, const Electrodes& is_still, Signals* noise2,
                                  Covariance* inverse) noexcept {
  for (;;) {
    const Signals y = *inverse * x;
    const Signals residual = y.cwiseQuotient(inverse->diagonal().cwiseSqrt());
    pressure_residual_ = residual[kElectrodeCount];
    mahalanobis2_ = x.dot(y) / (kPatternSignals - replaced_);
    Signals away = residual.cwiseAbs();
    away[kElectrodeCount] = 0;
    for (Eigen::Index i = 0; i < kElectrodeCount; ++i) {
      if (is_wrong_[static_cast<std::size_t>(i)]) away[i] = 0;
      if (is_still[static_cast<std::size_t>(i)]) away[i] *= kOutlier / kStillOutlier;
    }
    Eigen::Index worst = 0;
    if (away.maxCoeff(&worst) < kOutlier || replaced_ >= kMaxReplaced) return;
    is_wrong_[static_cast<std::size_t>(worst)] = true;
    ++replaced_;
    (*noise2)[worst] += ElectrodeJumps::kUnknown2;
    // S⁻¹ with a larger variance of one signal (Sherman and Morrison).
    const Signals column = inverse->col(worst);
    *inverse -= column * column.transpose() / (1 / ElectrodeJumps::kUnknown2 + column[worst]);
  }
}

// Estimates drift as the slow common part of the residuals. `known`: w.
void SignalModel::TrackDrift(const Signals& x, const Covariance& inverse,
                             const Signals& known) noexcept {
  const Signals together = Together();
  const double variance = 1 / together.dot(inverse * together);
  const double drift = together.dot(inverse * x) * variance;
  const double expected = together.dot(known) / kElectrodeCount;
  const double beyond =
      drift * drift - kSignificant * kSignificant * (variance - drift2_ - expected * expected);
  drift2_ += share_ * (std::max(0.0, beyond) - drift2_);
  drift_ += share_ * (drift - drift_);
}

// `excess`: covariance of the removed part.
void SignalModel::Correct(const TactileSignals& change, const Signals& x, const Covariance& excess,
                          const Covariance& inverse) noexcept {
  const Signals expected = x - excess * (inverse * x);
  corrected_ = change;
  for (Eigen::Index i = 0; i < kElectrodeCount; ++i) {
    corrected_[static_cast<std::size_t>(i)] = expected[i];
  }
  corrected_[kElectrodeCount + 1] = expected[kElectrodeCount];
  const Covariance error = excess - excess * inverse * excess;
  force_sigma_ = std::sqrt(std::max(0.0, (force_ * error * force_.transpose()).trace()));
}

}  // namespace palpate
