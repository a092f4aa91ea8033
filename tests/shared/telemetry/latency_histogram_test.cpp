#include "shared/telemetry/latency_histogram.h"

#include <limits>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Reference: the exact quantile of 1..10000 us. Tolerance: a bin is 2 % wide.
TEST(LatencyHistogramTest, QuantilesLieWithinABinOfTheExactOnes) {
  LatencyHistogram histogram;
  for (int i = 1; i <= 10000; ++i) histogram.Add(i);
  for (const double q : {0.01, 0.5, 0.99, 0.999}) {
    EXPECT_NEAR(histogram.Quantile(q) / (q * 10000), 1.0, 0.02) << "q = " << q;
  }
  EXPECT_EQ(histogram.max(), 10000);
}

TEST(LatencyHistogramTest, WhatIsNoTimeCountsAsZero) {
  LatencyHistogram histogram;
  histogram.Add(std::numeric_limits<double>::quiet_NaN());
  histogram.Add(std::numeric_limits<double>::infinity());
  histogram.Add(-3);
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_EQ(histogram.max(), 0);
}

}  // namespace
}  // namespace palpate
