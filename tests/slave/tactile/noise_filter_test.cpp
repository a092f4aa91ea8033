// Signals that noise is taken off, and what must come through it.
#include "slave/tactile/noise_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/normal_noise.h"

namespace palpate {
namespace {

using Signals = NoiseFilter::Signals;
constexpr std::array<bool, kPatternSignals> kNoneOut{};

class NoisySignals {
 public:
  // Each signal is at `level`, with noise `times` the usual one [counts].
  Signals At(double level, double times) {
    Signals noise;
    for (double& x : noise) x = normal_(random_);
    return Signals::Constant(level) + times * noise.cwiseProduct(UsualNoise2().cwiseSqrt());
  }

 private:
  std::mt19937_64 random_{7};
  NormalNoise normal_;
};

double Rms(double squares, int samples) {
  return std::sqrt(squares / (samples * kPatternSignals));
}

// A press of half a second: a third and more of the noise goes.
TEST(NoiseFilter, TakesTheNoiseOffAPress) {
  NoiseFilter filter;
  NoisySignals signals;
  double raw2 = 0, steady2 = 0;
  for (int i = 0; i < 100; ++i) {
    const double level = 50 * (1 - std::cos(0.0628 * i));
    const Signals x = signals.At(level, 4);
    const Signals steady = filter.Take(x, 4, kNoneOut);
    if (i < 20) continue;
    raw2 += (x.array() - level).square().sum();
    steady2 += (steady.array() - level).square().sum();
  }
  EXPECT_LT(Rms(steady2, 80) / Rms(raw2, 80), 0.7);  // 0.62 seen
}

TEST(NoiseFilter, UsualNoisePassesBitForBit) {
  NoiseFilter filter;
  NoisySignals signals;
  for (int i = 0; i < 20; ++i) {
    const Signals x = signals.At(i, 1);
    EXPECT_EQ(filter.Take(x, 1.1, kNoneOut), x);
    EXPECT_EQ(filter.left(), 1);
  }
}

// A contact lost from one sample to the next is not mourned.
TEST(NoiseFilter, AStepIsFollowedAtOnce) {
  NoiseFilter filter;
  NoisySignals signals;
  for (int i = 0; i < 50; ++i) filter.Take(signals.At(100, 3), 3, kNoneOut);
  EXPECT_LT(filter.Take(signals.At(0, 3), 3, kNoneOut).cwiseAbs().mean(), 10);
}

TEST(NoiseFilter, WhatIsOutIsWhatItWasExpectedToBe) {
  NoiseFilter filter;
  NoisySignals signals;
  for (int i = 0; i < 50; ++i) filter.Take(signals.At(30, 2), 2, kNoneOut);
  std::array<bool, kPatternSignals> out{};
  out[3] = true;
  Signals x = signals.At(30, 2);
  x[3] = 4000;
  EXPECT_NEAR(filter.Take(x, 2, out)[3], 30, 5);
}

}  // namespace
}  // namespace palpate
