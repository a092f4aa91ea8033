#include "slave/statistics/robust.h"

#include <array>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(Robust, TheMedianIsTheUpperOneInTheMiddle) {
  EXPECT_EQ(MedianOf(std::vector{3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(MedianOf(std::array{4, 1, 3, 2}), 3);
}

// Reference: normal samples, a fifth of them moved far away. Tolerance: with a fifth of outliers
// the median of the absolute values rises at most to the corresponding higher quantile of the
// normal samples.
TEST(Robust, WrongSamplesHardlyMoveTheSigma) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(5, 2);
  std::vector<double> values;
  for (int i = 0; i < 10'000; ++i) values.push_back(normal(random));
  EXPECT_NEAR(SigmaAboutMedian(std::vector(values)), 2, 0.06);
  for (std::size_t i = 0; i < values.size(); i += 5) values[i] += i % 2 == 0 ? 1e6 : -1e6;
  EXPECT_NEAR(SigmaAboutMedian(values), 2, 0.8);
}

TEST(Robust, TheBiweightEndsAtTheCut) {
  EXPECT_EQ(Biweight(0), 1);
  EXPECT_EQ(Biweight(0.5), 0.5625);
  EXPECT_EQ(Biweight(-1), 0);
  EXPECT_EQ(Biweight(7), 0);
}

}  // namespace
}  // namespace palpate
