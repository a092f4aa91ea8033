#include "slave/tactile/signal_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

constexpr double kSecondDifference = 6;  // [-] [derived: variances of noise in x - 2 x' + x'']
constexpr double kLesser = 0.77;         // expected fraction of the smaller one of two squares [-]
constexpr double kNoisy = 1.3;       // relative noise, from where on the lesser is compensated [-]
constexpr double kWildest = 50;      // limit of a squared second difference [counts^2]
constexpr double kSameNoise = 0.03;  // sigma of the measured noise's logarithm [-]
constexpr double kMaxGain = 0.3;  // largest logarithm of a gain that increased noise indicates [-]
constexpr double kGainParts = 1.5;  // sigma of the gain relative to the indicated one [-]
constexpr int kBeginning = 60;      // samples that determine the noise at the start

}  // namespace

SignalNoise::SignalNoise(double rate) : share_(1 - std::exp(-1 / (kMeasuringTime * rate))) {
  Reset();
}

void SignalNoise::Reset() noexcept {
  noise2_ = UsualNoise2();
  mean2_ = 0;
  relative_ = first_ = 1;
  seen_ = 0;
}

void SignalNoise::Update(const Signals& x, const Signals& residual,
                         const Electrodes& is_known) noexcept {
  if (seen_ >= 2) {
    Signals second2 = (residual - 2 * residual_ + before_residual_)
                          .cwiseAbs2()
                          .cwiseMin((x - 2 * x_ + before_x_).cwiseAbs2());
    for (Eigen::Index i = 0; i < kElectrodeCount; ++i) {
      if (!is_known[static_cast<std::size_t>(i)]) second2[i] = kSecondDifference * noise2_[i];
    }
    noise2_ += share_ * (second2 / kSecondDifference - noise2_);
    const double first = seen_ <= kBeginning ? 1.0 / (seen_ - 1) : 0;
    const double mean2 = second2.head<kElectrodeCount>().cwiseMin(kWildest).mean();
    mean2_ += std::max(share_, first) * (mean2 - mean2_);
    relative_ = std::sqrt(mean2_ / (kLesser * kSecondDifference * UsualNoise2()[0]));
    if (seen_ <= kBeginning) first_ = relative_;
  }
  before_residual_ = std::exchange(residual_, residual);
  before_x_ = std::exchange(x_, x);
  ++seen_;
}

double SignalNoise::gain_sigma() const noexcept {
  const double indicated = std::min(std::abs(std::log(relative_)), kMaxGain);
  return std::sqrt(std::max(0.0, indicated * indicated - kSameNoise * kSameNoise)) / kGainParts;
}

SignalNoise::Signals SignalNoise::variances() const noexcept {
  const double lesser = relative_ < kNoisy ? 1 : kLesser;
  return (noise2_ / lesser).cwiseMax(UsualNoise2());
}

}  // namespace palpate
