#include "slave/tactile/rest_trend.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr int kRest = 50;  // samples

class RestTrendTest : public ::testing::Test {
 protected:
  // Electrodes `moved` from where they began, half of them the other way, with a count of noise.
  FingerReading Reading(double moved) {
    FingerReading reading;
    reading.present = true;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const double at = 3000 + 10.0 * static_cast<double>(i) + (i % 2 == 0 ? moved : -moved);
      reading.electrodes[i] = static_cast<float>(std::round(at + noise_(random_)));
    }
    reading.pdc = 2000;
    return reading;
  }
  void Rest(double slope) {  // counts per sample
    for (; now_ < kRest; ++now_) {
      rest_.Advance();
      rest_.Take(Reading(slope * now_));
    }
  }
  // Rms of the electrodes' change `samples` after rest was taken last, untouched.
  double ErrorAfter(int samples, double slope) {
    for (int i = 0; i < samples; ++i, ++now_) rest_.Advance();
    const TactileSignals change = rest_.Change(Reading(slope * (now_ - 1)));
    double square = 0;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) square += change[i] * change[i];
    return std::sqrt(square / kElectrodeCount);
  }

  RestTrend rest_{kRest};
  int now_ = 0;
  std::mt19937 random_{5};
  std::normal_distribution<double> noise_{0, 0.9};
};

TEST_F(RestTrendTest, ADriftThatStandsOutGoesOnWhileNothingTellsOfIt) {
  Rest(0.1);
  EXPECT_LT(ErrorAfter(60, 0.1), 2.5);  // of 8.5 counts from the middle of the rest samples
  EXPECT_GT(rest_.variance(), 0.5);
}

TEST_F(RestTrendTest, WithoutDriftRestIsTheMeanAndStays) {
  Rest(0);
  EXPECT_LT(ErrorAfter(500, 0), 1.3);  // noise, rounding and the mean's own
  EXPECT_LT(rest_.variance(), 0.2);
}

// Ten minutes at 100 Hz, after a drift that ended with the rest samples.
TEST_F(RestTrendTest, ADriftIsNotTakenToGoOnForAsLongAsSomethingIsHeld) {
  Rest(0.1);
  for (int i = 0; i < 60000; ++i) rest_.Advance();
  const TactileSignals change = rest_.Change(Reading(0.1 * kRest)), astray = rest_.astray();
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    EXPECT_LT(std::abs(change[i]), 200) << i;
    EXPECT_LT(std::abs(change[i]), 3 * std::abs(astray[i])) << i;
  }
}

TEST_F(RestTrendTest, ADriftWithoutNoiseIsFollowed) {
  noise_ = std::normal_distribution<double>(0, 1e-9);
  Rest(1);
  for (int i = 0; i < 100; ++i) rest_.Advance();
  const TactileSignals change = rest_.Change(Reading(kRest - 1 + 100)), astray = rest_.astray();
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    EXPECT_LT(std::abs(change[i]), 15) << i;
    EXPECT_TRUE(std::isfinite(astray[i])) << i;
  }
}

// How long a weak drift goes on is not known, and its direction is.
TEST_F(RestTrendTest, WhereADriftMayHaveGoneIsADirection) {
  Rest(0.1);
  EXPECT_EQ(rest_.astray(), TactileSignals{});
  for (int i = 0; i < 100; ++i) rest_.Advance();
  const TactileSignals astray = rest_.astray();
  EXPECT_GT(astray[0], 2);
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    EXPECT_NEAR(astray[i], i % 2 == 0 ? astray[0] : -astray[0], 0.3 * astray[0]) << i;
  }
}

// Reference: 100 (1 - exp(-t / 100)) counts. The line through the same samples ends 90 counts off.
TEST_F(RestTrendTest, AFingertipThatWarmsUpSlowsDown) {
  const auto warm = [](double t) { return 100 * (1 - std::exp(-t / 100)); };
  for (; now_ < kRest; ++now_) {
    rest_.Advance();
    rest_.Take(Reading(warm(now_)));
  }
  for (int i = 0; i < 200; ++i) rest_.Advance();
  const TactileSignals change = rest_.Change(Reading(warm(now_ - 1 + 200)));
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    EXPECT_LT(std::abs(change[i]), 8) << i;
    EXPECT_LT(std::abs(change[i]), 3 * std::hypot(1, rest_.astray()[i])) << i;
  }
}

// Reference: the end of a line through n values of variance v, 4 v / n; without a slope v / n.
TEST_F(RestTrendTest, ThePressureIsKnownAsWellAsItsLine) {
  for (const double slope : {0.0, 0.3}) {
    rest_.Reset();
    double squares = 0;
    for (int i = 0; i < kRest; ++i) {
      rest_.Advance();
      FingerReading reading = Reading(slope * i);
      const double noise = noise_(random_);
      squares += noise * noise;
      reading.pdc += static_cast<float>(slope * i + noise);
      rest_.Take(reading);
    }
    const double known = (slope > 0 ? 4 : 1) * squares / kRest / kRest;
    EXPECT_NEAR(rest_.pressure_variance(), known, 0.25 * known) << slope;
  }
}

TEST_F(RestTrendTest, WhatStepsIsRest) {
  Rest(0);
  rest_.Shift(20);
  FingerReading reading = Reading(0);
  for (float& electrode : reading.electrodes) electrode += 20;
  rest_.Advance();
  EXPECT_NEAR(rest_.Change(reading)[3], 0, 4);
}

}  // namespace
}  // namespace palpate
