#include "slave/tactile/signal_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "shared/statistics/robust.h"

namespace palpate {
namespace {

constexpr double kSecondDifference = 6;  // [-] [derived: variances of noise in x - 2 x' + x'']
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

}  // namespace

SignalNoise::SignalNoise(double rate)
    : share_(1 - std::exp(-1 / (kMeasuringTime * rate))),
      level_share_(1 - std::exp(-1 / (kLevelTime * rate))) {
  Reset();
}

void SignalNoise::Reset() noexcept {
  noise2_ = UsualNoise2();
  level2_ = 0;
  levels2_.setZero();
  noise_ = first_noise_ = 1;
  seen_ = 0;
}

void SignalNoise::Take(const Signals& x, const Signals& off, const Electrodes& is_known) noexcept {
  if (seen_ >= 2) {
    Signals jerk2 =
        (off - 2 * off_ + before_off_).cwiseAbs2().cwiseMin((x - 2 * x_ + before_x_).cwiseAbs2());
    for (Eigen::Index i = 0; i < kElectrodeCount; ++i) {
      if (!is_known[static_cast<std::size_t>(i)]) jerk2[i] = kSecondDifference * noise2_[i];
    }
    noise2_ += share_ * (jerk2 / kSecondDifference - noise2_);
    const Signals tame2 = jerk2.cwiseMin(kWildest);
    const double first = seen_ <= kBeginning ? 1.0 / (seen_ - 1) : 0;
    level2_ += std::max(share_, first) * (tame2.head(kElectrodeCount).mean() - level2_);
    levels2_ += std::max(level_share_, first) * (tame2 - levels2_);
    noise_ = std::sqrt(level2_ / (kLesser * kSecondDifference * UsualNoise2()[0]));
    // What differs from electrode to electrode, as coarse counts do, tells nothing of all gains.
    if (seen_ <= kBeginning || Unevenness() > kEven) first_noise_ = noise_;
  }
  before_off_ = std::exchange(off_, off);
  before_x_ = std::exchange(x_, x);
  ++seen_;
}

SignalNoise::Signals SignalNoise::variances() const noexcept {
  const double lesser = noise_ < kNoisy ? 1 : kLesser;
  return (noise2_ / lesser).cwiseMax(UsualNoise2());
}

double SignalNoise::gain_sigma() const noexcept {
  const auto beyond = [](double off, double usual) {
    const double most = std::min(off, kLargestGain);
    return std::sqrt(std::max(0.0, most * most - usual * usual));
  };
  return std::hypot(beyond(std::abs(std::log(noise_)), kSameNoise) / kTelltale,
                    beyond(Unevenness(), kEven));
}

double SignalNoise::Unevenness() const noexcept {
  if (seen_ < kTelling) return 0;
  std::array<double, kElectrodeCount> logs;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    logs[i] = std::log(std::max(levels2_[static_cast<Eigen::Index>(i)], 1e-6)) / 2;
  }
  return SigmaAboutMedian(logs);
}

}  // namespace palpate
