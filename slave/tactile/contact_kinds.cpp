#include "slave/tactile/contact_kinds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

namespace palpate {
namespace {

using Signals = SignalPattern::Signals;
using Covariance = SignalPattern::Covariance;

constexpr double kTypicalSize = 60;     // [counts]
constexpr std::size_t kCandidates = 3;  // kinds that are looked at closely

double LogDeterminant(const Eigen::LLT<Covariance>& factor) {
  return 2 * factor.matrixLLT().diagonal().array().log().sum();
}

// Least x' S⁻¹ x with one signal left out, if that is `kOutlier` away; `y`: S⁻¹ x.
double RobustSquare(const Signals& x, const Signals& y, const Covariance& inverse) {
  const double outlier = (y.cwiseAbs2().cwiseQuotient(inverse.diagonal())).maxCoeff();
  return x.dot(y) - std::max(0.0, outlier - ContactKinds::kOutlier * ContactKinds::kOutlier);
}

}  // namespace

ContactKinds::ContactKinds(const SignalPattern& pattern) {
  for (const SignalPattern::Kind& kind : pattern.kinds) {
    Covariance S = kind.shape;
    S += (UsualNoise2() / (kTypicalSize * kTypicalSize)).asDiagonal();
    const Eigen::LLT<Covariance> factor(S);
    kinds_.push_back({kind.share, kind.shape, factor.solve(Covariance::Identity()),
                      LogDeterminant(factor) - 2 * std::log(kind.share)});
  }
}

ContactKinds::Explanation ContactKinds::Explain(const Signals& x, const Signals& noise2,
                                                const Covariance& drift,
                                                double size2) const noexcept {
  const Signals unit = x / std::sqrt(size2);
  std::array<std::pair<double, std::size_t>, kCandidates> best;
  best.fill({std::numeric_limits<double>::infinity(), 0});
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    const Signals y = kinds_[k].inverse * unit;
    const std::pair here{RobustSquare(unit, y, kinds_[k].inverse) + kinds_[k].offset, k};
    if (here < best.back()) best.back() = here;
    std::ranges::sort(best);
  }
  const auto explain_by = [&](std::size_t kind) {
    Covariance S = size2 * kinds_[kind].shape + drift;
    S += noise2.asDiagonal();
    const Eigen::LLT<Covariance> factor(S);
    Explanation by{kind, 0, factor.solve(Covariance::Identity())};
    by.cost = RobustSquare(x, by.inverse * x, by.inverse) + LogDeterminant(factor) -
              2 * std::log(kinds_[kind].share);
    return by;
  };
  Explanation least = explain_by(best.front().second);
  for (std::size_t i = 1; i < kCandidates && best[i].first < 1e300; ++i) {
    const Explanation other = explain_by(best[i].second);
    if (other.cost < least.cost) least = other;
  }
  return least;
}

}  // namespace palpate
