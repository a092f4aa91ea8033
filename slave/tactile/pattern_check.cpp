#include "slave/tactile/pattern_check.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

using Signals = SignalPattern::Signals;
using Covariance = SignalPattern::Covariance;

// Times the usual variance: nothing to mend. [-] [tuned: NoiseIsTakenOffAsFarAsItIsMoreThanUsual]
constexpr double kQuiet = 4;
constexpr double kLeastSize = 10;      // so that gentle touches are not taken for noise [counts]
constexpr double kStillOutlier = 1.3;  // kOutlier of one that stands still, as no live one does
constexpr double kSettled = 3;         // of these a common drift must stand out
constexpr int kMostReplaced = 4;       // of electrodes; with more nobody knows which are right
constexpr double kLevelling = 0.1;     // share of a sample in what is told

// What a drift of one count of all electrodes does.
Signals Together() {
  Signals together = Signals::Ones();
  together[kElectrodeCount] = 0;
  return together;
}

// S⁻¹ once signal `i` has an unknown noise more (Sherman and Morrison).
void LeaveOut(Eigen::Index i, Covariance* inverse) {
  const Signals column = inverse->col(i);
  *inverse -= column * column.transpose() / (1 / ElectrodeJumps::kUnknown2 + column[i]);
}

}  // namespace

PatternCheck::PatternCheck(const SignalPattern& pattern, double rate)
    : kinds_(pattern),
      force_(pattern.force),
      noise_(rate),
      share_(1 - std::exp(-1 / (SignalNoise::kMeasuringTime * rate))) {
  Reset();
}

void PatternCheck::Reset() noexcept {
  noise_.Reset();
  jumps_.Reset();
  drift2_ = drift_ = 0;
  misfit_ = misfit_now_ = 1;
  disagreement_ = 0;
}

void PatternCheck::Take(const TactileSignals& change, const Electrodes& is_dead,
                        const Electrodes& is_still, double rest2,
                        const TactileSignals& astray) noexcept {
  astray_ = PatternSignals(astray);
  const Signals x = PatternSignals(change);
  jumps_.Take(x, noise_.relative());
  Signals noise2 = noise_.variances(), alive = x;
  noise2.head(kElectrodeCount).array() += rest2;
  is_wrong_.fill(false);
  replaced_ = 0;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    if (!is_dead[i] && !jumps_.is_out(i)) continue;
    is_wrong_[i] = true;
    ++replaced_;
    alive[static_cast<Eigen::Index>(i)] = 0;
    noise2[static_cast<Eigen::Index>(i)] = ElectrodeJumps::kUnknown2;
  }
  const double size2 = std::max(alive.squaredNorm() - UsualNoise2().sum(), kLeastSize * kLeastSize);
  auto explained = kinds_.Explain(alive, noise2, Drift(), size2);
  kind_ = explained.kind;
  LeaveOutWrong(alive, is_still, &noise2, &explained.inverse);
  Measure(alive, explained.inverse);
  jumps_.Reinstate(x, alive, explained.inverse);
  Mend(change, alive, noise2, explained.inverse);
}

Covariance PatternCheck::Drift() const noexcept {
  const Signals together = Together();
  return drift2_ * together * together.transpose() + astray_ * astray_.transpose();
}

// Drift is what the distances from what is expected have in common for longer than noise lasts.
void PatternCheck::Measure(const Signals& x, const Covariance& inverse) noexcept {
  const Signals y = inverse * x, together = Together();
  noise_.Take(x, y.cwiseQuotient(inverse.diagonal()), jumps_.calm());
  const double variance = 1 / together.dot(inverse * together);
  const double drift = together.dot(y) * variance;
  const double known = together.dot(astray_) / kElectrodeCount;  // that they may have, too
  const double beyond = drift * drift - kSettled * kSettled * (variance - drift2_ - known * known);
  drift2_ += share_ * (std::max(0.0, beyond) - drift2_);
  drift_ += share_ * (drift - drift_);
}

void PatternCheck::LeaveOutWrong(const Signals& x, const Electrodes& is_still, Signals* noise2,
                                 Covariance* inverse) noexcept {
  double misfit = 0, disagreement = 0;
  for (;;) {
    const Signals y = *inverse * x;
    Signals away = y.cwiseAbs().cwiseQuotient(inverse->diagonal().cwiseSqrt());
    disagreement = away[kElectrodeCount];
    away[kElectrodeCount] = 0;
    for (Eigen::Index i = 0; i < kElectrodeCount; ++i) {
      if (is_wrong_[static_cast<std::size_t>(i)]) away[i] = 0;
      if (is_still[static_cast<std::size_t>(i)]) away[i] *= ContactKinds::kOutlier / kStillOutlier;
    }
    misfit = x.dot(y) / (kPatternSignals - replaced_);
    Eigen::Index worst = 0;
    if (away.maxCoeff(&worst) < ContactKinds::kOutlier || replaced_ >= kMostReplaced) break;
    is_wrong_[static_cast<std::size_t>(worst)] = true;
    ++replaced_;
    (*noise2)[worst] += ElectrodeJumps::kUnknown2;
    LeaveOut(worst, inverse);
  }
  misfit_now_ = misfit;
  misfit_ += kLevelling * (misfit - misfit_);
  disagreement_ += kLevelling * (disagreement - disagreement_);
}

// Only what is more than usual is taken off: the network has learnt to live with the rest.
void PatternCheck::Mend(const TactileSignals& change, const Signals& x, const Signals& noise2,
                        const Covariance& inverse) noexcept {
  Covariance M = Drift();
  M += (noise2 - kQuiet * UsualNoise2()).cwiseMax(0).asDiagonal();
  const Signals expected = x - M * (inverse * x);
  mended_ = change;
  for (Eigen::Index i = 0; i < kElectrodeCount; ++i) {
    mended_[static_cast<std::size_t>(i)] = expected[i];
  }
  mended_[kElectrodeCount + 1] = expected[kElectrodeCount];
  const Covariance error = M - M * inverse * M;  // of what is expected
  force_sigma_ = std::sqrt(std::max(0.0, (force_ * error * force_.transpose()).trace()));
}

}  // namespace palpate
