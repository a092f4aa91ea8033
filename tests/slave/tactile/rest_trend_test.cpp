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
