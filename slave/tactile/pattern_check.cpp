#include "slave/tactile/pattern_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "shared/statistics/robust.h"

namespace palpate {
namespace {

using Signals = SignalPattern::Signals;
using Covariance = SignalPattern::Covariance;

constexpr double kQuiet = 4;            // times the usual variance: nothing to mend
constexpr double kMeasuringTime = 0.3;  // of noise and drift [s]
constexpr double kLeastSize = 10;       // so that gentle touches are not taken for noise [counts]
constexpr double kTypicalSize = 60;     // [counts]
constexpr double kOutlier = 5.5;        // standard deviations from what is expected
constexpr double kStillOutlier = 1.3;   // the same of one that stands still, as no live one does
constexpr double kJump = 8;             // times what the others move from sample to sample
constexpr double kBack = 0.3;           // part of a jump that is left when it was a spike
constexpr double kAsExpected = 1.5;     // standard deviations, for so many samples:
constexpr int kReinstated = 20;
constexpr double kSettled = 3;           // of these a common drift must stand out
constexpr int kMostReplaced = 4;         // of electrodes; with more nobody knows which are right
constexpr double kUnknown2 = 1e6;        // variance of what is left out [counts^2]
constexpr double kSecondDifference = 6;  // variances of noise in x - 2 x' + x''
constexpr double kLevelling = 0.1;       // share of a sample in what is told
constexpr std::size_t kCandidates = 3;   // kinds that are looked at closely
constexpr double kLevelTime = 1;         // of each electrode's noise [s]
constexpr double kLesser = 0.77;         // of a square in the lesser one of two
constexpr double kNoisy = 1.3;           // times the usual noise, from where on that is made good
constexpr double kWildest = 50;          // second difference that counts for all [counts^2]
constexpr double kSameNoise = 0.03;      // of its logarithm: one sigma of what is measured of it
constexpr int kTelling = 80;             // samples, before an electrode's noise is known
constexpr int kBeginning = 60;           // samples, whose noise is that at the start
constexpr double kEven = 0.2;            // of its differences; five real fingers: 0.08 to 0.18
constexpr double kTelltale = 1.5;        // parts of what the noise says of the gain: one sigma
constexpr double kLargestGain = 0.3;     // that comes with noise; more is noise alone

// What a drift of one count of all electrodes does.
Signals Together() {
  Signals together = Signals::Ones();
  together[kElectrodeCount] = 0;
  return together;
}

double LogDeterminant(const Eigen::LLT<Covariance>& factor) {
  return 2 * factor.matrixLLT().diagonal().array().log().sum();
}

// Least x' S⁻¹ x with one signal left out, if that is `kOutlier` away; `y`: S⁻¹ x.
double RobustSquare(const Signals& x, const Signals& y, const Covariance& inverse) {
  const double outlier = (y.cwiseAbs2().cwiseQuotient(inverse.diagonal())).maxCoeff();
  return x.dot(y) - std::max(0.0, outlier - kOutlier * kOutlier);
}

// S⁻¹ once signal `i` has an unknown noise more (Sherman and Morrison).
void LeaveOut(Eigen::Index i, Covariance* inverse) {
  const Signals column = inverse->col(i);
  *inverse -= column * column.transpose() / (1 / kUnknown2 + column[i]);
}

}  // namespace

PatternCheck::PatternCheck(const SignalPattern& pattern, double rate)
    : pattern_(pattern),
      share_(1 - std::exp(-1 / (kMeasuringTime * rate))),
      level_share_(1 - std::exp(-1 / (kLevelTime * rate))) {
  for (const SignalPattern::Kind& kind : pattern_.kinds) {
    Covariance S = kind.shape;
    S += (UsualNoise2() / (kTypicalSize * kTypicalSize)).asDiagonal();
    const Eigen::LLT<Covariance> factor(S);
    quick_.push_back(
        {factor.solve(Covariance::Identity()), LogDeterminant(factor) - 2 * std::log(kind.share)});
  }
  Reset();
}

void PatternCheck::Reset() noexcept {
  noise2_ = UsualNoise2();
  drift2_ = drift_ = level2_ = 0;
  levels2_.setZero();
  misfit_ = misfit_now_ = noise_ = first_noise_ = 1;
  jumped_.fill(0);
  calm_.fill(0);
  disagreement_ = 0;
  seen_ = 0;
}

void PatternCheck::Take(const TactileSignals& change, const Electrodes& is_dead,
                        const Electrodes& is_still, double rest2,
                        const TactileSignals& astray) noexcept {
  astray_ = PatternSignals(astray);
  const Signals x = PatternSignals(change);
  NoteJumps(x);
  const double lesser = noise_ < kNoisy ? 1 : kLesser;
  Signals noise2 = (noise2_ / lesser).cwiseMax(UsualNoise2()), alive = x;
  noise2.head(kElectrodeCount).array() += rest2;
  is_wrong_.fill(false);
  replaced_ = 0;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    calm_[i] = jumped_[i] == 0 ? calm_[i] + 1 : 0;
    if (!is_dead[i] && jumped_[i] == 0) continue;
    is_wrong_[i] = true;
    ++replaced_;
    alive[static_cast<Eigen::Index>(i)] = 0;
    noise2[static_cast<Eigen::Index>(i)] = kUnknown2;
  }
  const double size2 = std::max(alive.squaredNorm() - UsualNoise2().sum(), kLeastSize * kLeastSize);
  Reading reading = Explain(alive, noise2, size2);
  kind_ = reading.kind;
  LeaveOutWrong(alive, is_still, &noise2, &reading.inverse);
  Measure(alive, reading.inverse);
  Reinstate(x, alive, reading.inverse);
  Mend(change, alive, noise2, reading.inverse);
  raw_ = x;
}

PatternCheck::Reading PatternCheck::Explain(const Signals& x, const Signals& noise2,
                                            double size2) noexcept {
  const Signals unit = x / std::sqrt(size2);
  std::array<std::pair<double, std::size_t>, kCandidates> best;
  best.fill({std::numeric_limits<double>::infinity(), 0});
  for (std::size_t k = 0; k < quick_.size(); ++k) {
    const Signals y = quick_[k].inverse * unit;
    const std::pair here{RobustSquare(unit, y, quick_[k].inverse) + quick_[k].offset, k};
    if (here < best.back()) best.back() = here;
    std::ranges::sort(best);
  }
  Reading reading = ExplainBy(best.front().second, x, noise2, size2);
  for (std::size_t i = 1; i < kCandidates && best[i].first < 1e300; ++i) {
    const Reading other = ExplainBy(best[i].second, x, noise2, size2);
    if (other.cost < reading.cost) reading = other;
  }
  return reading;
}

PatternCheck::Reading PatternCheck::ExplainBy(std::size_t kind, const Signals& x,
                                              const Signals& noise2, double size2) const noexcept {
  Covariance S = size2 * pattern_.kinds[kind].shape + Drift();
  S += noise2.asDiagonal();
  const Eigen::LLT<Covariance> factor(S);
  Reading reading{kind, 0, factor.solve(Covariance::Identity())};
  reading.cost = RobustSquare(x, reading.inverse * x, reading.inverse) + LogDeterminant(factor) -
                 2 * std::log(pattern_.kinds[kind].share);
  return reading;
}

Covariance PatternCheck::Drift() const noexcept {
  const Signals together = Together();
  return drift2_ * together * together.transpose() + astray_ * astray_.transpose();
}

// Noise is what each signal, or its distance from what is expected, does from sample to sample,
// whichever does less: a contact that begins is none, nor is another kind that explains it. Drift
// is what the distances have in common for longer.
void PatternCheck::Measure(const Signals& x, const Covariance& inverse) noexcept {
  const Signals y = inverse * x, together = Together();
  const Signals off = y.cwiseQuotient(inverse.diagonal());
  const double variance = 1 / together.dot(inverse * together);
  const double drift = together.dot(y) * variance;
  if (seen_ >= 2) {
    Signals jerk2 =
        (off - 2 * off_ + before_off_).cwiseAbs2().cwiseMin((x - 2 * x_ + before_x_).cwiseAbs2());
    LeaveOutJumps(&jerk2);
    noise2_ += share_ * (jerk2 / kSecondDifference - noise2_);
    const Signals tame2 = jerk2.cwiseMin(kWildest);
    const double first = seen_ <= kBeginning ? 1.0 / (seen_ - 1) : 0;
    level2_ += std::max(share_, first) * (tame2.head(kElectrodeCount).mean() - level2_);
    levels2_ += std::max(level_share_, first) * (tame2 - levels2_);
    noise_ = std::sqrt(level2_ / (kLesser * kSecondDifference * UsualNoise2()[0]));
    // What differs from electrode to electrode, as coarse counts do, tells nothing of all gains.
    if (seen_ <= kBeginning || unevenness() > kEven) first_noise_ = noise_;
  }
  const double known = together.dot(astray_) / kElectrodeCount;  // that they may have, too
  const double beyond = drift * drift - kSettled * kSettled * (variance - drift2_ - known * known);
  drift2_ += share_ * (std::max(0.0, beyond) - drift2_);
  drift_ += share_ * (drift - drift_);
  before_off_ = std::exchange(off_, off);
  before_x_ = std::exchange(x_, x);
  ++seen_;
}

// A second difference looks back over three samples: what jumped in them tells nothing of noise.
void PatternCheck::LeaveOutJumps(Signals* jerk2) const noexcept {
  for (Eigen::Index i = 0; i < kElectrodeCount; ++i) {
    if (calm_[static_cast<std::size_t>(i)] < 3) (*jerk2)[i] = kSecondDifference * noise2_[i];
  }
}

// A contact moves neighbours, too, and none of them between two samples by far the most: an
// electrode that does has lost its contact, or was exchanged for another. It is left out until it
// has come back, or has been what is expected for a while.
void PatternCheck::NoteJumps(const Signals& x) noexcept {
  if (seen_ == 0) return;
  std::array<double, kElectrodeCount> moved;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    moved[i] = std::abs(x[static_cast<Eigen::Index>(i)] - raw_[static_cast<Eigen::Index>(i)]);
  }
  std::array<double, kElectrodeCount> sorted = moved;
  std::ranges::sort(sorted);
  // Most of the others: a quarter of all may jump at once.
  const double usual = std::max(sorted[kElectrodeCount * 3 / 4], noise_);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (moved[i] < kJump * usual) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const double jump = x[k] - raw_[k];
    const bool is_back = std::abs(jumped_[i] + jump) < kBack * std::abs(jump);
    jumped_[i] = is_back ? 0 : jump;
    agrees_[i] = 0;
  }
}

// `alive`: x without the electrodes left out, which `inverse` goes by.
void PatternCheck::Reinstate(const Signals& x, const Signals& alive,
                             const Covariance& inverse) noexcept {
  const Signals y = inverse * alive;
  for (std::size_t i = 0; i < jumped_.size(); ++i) {
    if (jumped_[i] == 0) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const double error = x[k] - alive[k] + y[k] / inverse(k, k);
    const double variance = std::max(1 / inverse(k, k) - kUnknown2, UsualNoise2()[0]);
    const bool agrees = error * error < kAsExpected * kAsExpected * variance;
    agrees_[i] = agrees ? agrees_[i] + 1 : 0;
    if (agrees_[i] >= kReinstated) jumped_[i] = 0;
  }
}

double PatternCheck::gain_sigma() const noexcept {
  const auto beyond = [](double off, double usual) {
    const double most = std::min(off, kLargestGain);
    return std::sqrt(std::max(0.0, most * most - usual * usual));
  };
  return std::hypot(beyond(std::abs(std::log(noise_)), kSameNoise) / kTelltale,
                    beyond(unevenness(), kEven));
}

double PatternCheck::unevenness() const noexcept {
  if (seen_ < kTelling) return 0;
  std::array<double, kElectrodeCount> logs;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    logs[i] = std::log(std::max(levels2_[static_cast<Eigen::Index>(i)], 1e-6)) / 2;
  }
  return SigmaAboutMedian(logs);
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
      if (is_still[static_cast<std::size_t>(i)]) away[i] *= kOutlier / kStillOutlier;
    }
    misfit = x.dot(y) / (kPatternSignals - replaced_);
    Eigen::Index worst = 0;
    if (away.maxCoeff(&worst) < kOutlier || replaced_ >= kMostReplaced) break;
    is_wrong_[static_cast<std::size_t>(worst)] = true;
    ++replaced_;
    (*noise2)[worst] += kUnknown2;
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
  force_sigma_ =
      std::sqrt(std::max(0.0, (pattern_.force * error * pattern_.force.transpose()).trace()));
}

}  // namespace palpate
