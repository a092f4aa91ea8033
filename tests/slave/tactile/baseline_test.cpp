#include "slave/tactile/baseline.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr int kSamplesAtRest = 50;  // samples

class BaselineTest : public ::testing::Test {
 protected:
  // Returns a reading with electrodes changed by `moved`, half of them in the opposite direction,
  // with noise of one count.
  FingerReading Reading(double moved) {
    FingerReading reading;
    reading.present = true;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const double at = 3000 + 10.0 * static_cast<double>(i) + (i % 2 == 0 ? moved : -moved);
      reading.channels[i] = static_cast<float>(std::round(at + noise_(random_)));
    }
    reading.pdc = 2000;
    return reading;
  }
  void Rest(double slope) {  // counts per sample
    for (; now_ < kSamplesAtRest; ++now_) {
      rest_.Advance();
      rest_.Take(Reading(slope * now_));
    }
  }
  // Returns the rms of the electrodes' change, without contact, `samples` after the last rest
  // sample.
  double ErrorAfter(int samples, double slope) {
    for (int i = 0; i < samples; ++i, ++now_) rest_.Advance();
    const TactileSignals change = rest_.Change(Reading(slope * (now_ - 1)));
    double square = 0;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) square += change[i] * change[i];
    return std::sqrt(square / kElectrodeCount);
  }

  Baseline rest_{kSamplesAtRest};
  int now_ = 0;
  std::mt19937 random_{5};
  std::normal_distribution<double> noise_{0, 0.9};
};

TEST_F(BaselineTest, ALargeDriftIsExtrapolated) {
  Rest(0.1);
  // The drift since the middle of the rest samples is 8.5 counts.
  EXPECT_LT(ErrorAfter(60, 0.1), 2.5);
  // The variance of a slope through 50 samples is 12 / 50^3 of the noise's 0.89 counts^2;
  // extrapolated by 60 samples.
  EXPECT_NEAR(rest_.variance(), 0.29, 0.1);
}

// Ten minutes at 100 Hz, after a drift that ended with the rest samples.
TEST_F(BaselineTest, ADriftIsNotExtrapolatedThroughALongContact) {
  Rest(0.1);
  for (int i = 0; i < 60000; ++i) rest_.Advance();
  const TactileSignals change = rest_.Change(Reading(0.1 * kSamplesAtRest)),
                       sigma = rest_.drift_sigma();
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    EXPECT_LT(std::abs(change[i]), 200) << i;
    EXPECT_LT(std::abs(change[i]), 3 * std::abs(sigma[i])) << i;
  }
}

// Reference: the spread of the extrapolated baseline over simulations of the same large drift.
// Tolerance: the code extrapolates from the last sample instead of the middle of the rest samples,
// whose distance is 4 % larger; and the fit absorbs 4 % of the noise's variance.
TEST_F(BaselineTest, TheVarianceOfAContinuingDriftAgreesWithSimulations) {
  constexpr int kRuns = 300, kAhead = 1000;
  double sum = 0, squares = 0, stated = 0;
  for (int run = 0; run < kRuns; ++run) {
    rest_.Reset();
    now_ = 0;
    Rest(1);
    for (int i = 0; i < kAhead; ++i) rest_.Advance();
    FingerReading reading;
    reading.channels.fill(3000);
    const double change = rest_.Change(reading)[0];
    sum += change;
    squares += change * change;
    stated += rest_.variance() / kRuns;
  }
  const double variance = squares / kRuns - sum * sum / kRuns / kRuns;
  EXPECT_NEAR(stated / variance, 1, 0.25);
}

// Reference: the end of a line through n values of variance v, 4 v / n; without a slope v / n.
TEST_F(BaselineTest, TheVarianceOfThePressureIsThatOfItsLine) {
  for (const double slope : {0.0, 0.3}) {
    rest_.Reset();
    double squares = 0;
    for (int i = 0; i < kSamplesAtRest; ++i) {
      rest_.Advance();
      FingerReading reading = Reading(slope * i);
      const double noise = noise_(random_);
      squares += noise * noise;
      reading.pdc += static_cast<float>(slope * i + noise);
      rest_.Take(reading);
    }
    const double known = (slope > 0 ? 4 : 1) * squares / kSamplesAtRest / kSamplesAtRest;
    EXPECT_NEAR(rest_.pressure_variance(), known, 0.25 * known) << slope;
  }
}

}  // namespace
}  // namespace palpate
