// Signals noisier than the network learnt from, steadied by what they did before: a Kalman filter
// of level and slope, its gain common to all of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "slave/tactile/signal_pattern.h"

namespace palpate {

// What moves faster than the filter expects, all signals taken together, is followed at once: its
// variance grows to what is seen (adaptive fading). What is hardly noisier than usual passes.
class NoiseFilter {
 public:
  using Signals = SignalPattern::Signals;
  static constexpr double kSame = 1.3;  // times the usual noise: passes

  void Reset() noexcept { seen_ = 0; }
  // The next sample, counts minus rest; `noise` of its signals, over the usual one; where `is_out`,
  // a signal is taken for what it was expected to be. Allocation-free.
  template <typename IsOut>
  Signals Take(const Signals& counts, double noise, const IsOut& is_out) noexcept {
    const Signals unit = UsualNoise2().cwiseSqrt(), x = counts.cwiseQuotient(unit);
    if (seen_++ == 0 || noise < kSame) Start(x);
    Predict();
    Signals off = x - level_;
    for (std::size_t i = 0; i < is_out.size(); ++i) {
      if (is_out[i]) off[static_cast<Eigen::Index>(i)] = 0;
    }
    Correct(off, noise * noise);
    left_ = noise < kSame ? 1 : level2_ / (noise * noise);
    return noise < kSame ? counts : level_.cwiseProduct(unit);
  }
  // Of the noise's variance, in the last sample [-].
  [[nodiscard]] double left() const noexcept { return left_; }

 private:
  static constexpr double kTurns = 0.09;  // variance of the slope's change from sample to sample
  static constexpr double kFar = 1.5, kLately = 0.5;  // times what is expected; share of a sample

  void Start(const Signals& x) noexcept {
    level_ = x;
    slope_.setZero();
    level2_ = 1, both_ = 0, slope2_ = kTurns;
    lately_ = 1;
  }
  void Predict() noexcept {
    level_ += slope_;
    level2_ += 2 * both_ + slope2_ + kTurns / 4;
    both_ += slope2_ + kTurns / 2;
    slope2_ += kTurns;
  }
  void Correct(const Signals& off, double noise2) noexcept {
    const double expected2 = level2_ + noise2;
    lately_ += kLately * (off.squaredNorm() / (kPatternSignals * expected2) - lately_);
    if (lately_ > kFar) level2_ += (lately_ - 1) * expected2;
    const double gain = level2_ / (level2_ + noise2), slope_gain = both_ / (level2_ + noise2);
    level_ += gain * off;
    slope_ += slope_gain * off;
    slope2_ -= slope_gain * both_;
    both_ *= 1 - gain;
    level2_ *= 1 - gain;
  }

  std::int64_t seen_ = 0;         // samples
  double left_ = 1, lately_ = 1;  // square of what was not expected, over what it was to be
  // In usual noises, and the covariance of both.
  Signals level_ = Signals::Zero(), slope_ = Signals::Zero();
  double level2_ = 0, both_ = 0, slope2_ = 0;
};

}  // namespace palpate
