#include "slave/study/richardson.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate::study {
namespace {

std::vector<MeshAnswer> Sequence(const std::vector<double>& sizes, double limit, double factor,
                                 double order) {
  std::vector<MeshAnswer> answers;
  for (const double h : sizes) answers.push_back({h, limit + factor * std::pow(h, order)});
  return answers;
}

// Reference: sequences made from the law itself, so limit and order are known. Tolerance: bisection
// to 2^-60, then rounding of differences as small as C h^p.
TEST(RichardsonTest, FindsLimitAndOrderOfAnExactSequenceWhateverTheRatios) {
  for (const double order : {0.5, 1.0, 1.5, 2.0, 3.0}) {
    for (const auto& sizes : {std::vector{1.0, 0.5, 0.25}, std::vector{1.0, 0.6, 0.4, 0.2, 0.07}}) {
      for (const double factor : {-0.3, 0.2}) {
        const Extrapolation found = Extrapolate(Sequence(sizes, 2.5, factor, order));
        EXPECT_NEAR(found.limit.value, 2.5, 1e-9) << order;
        EXPECT_NEAR(found.order, order, 1e-6);
      }
    }
  }
}

// A second power in the error makes the observed order only approximate; the stated uncertainty
// must include this.
TEST(RichardsonTest, BarCoversTheTruthOfMixedOrders) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int covered = 0, useful = 0;
  constexpr int kCases = 400;
  for (int i = 0; i < kCases; ++i) {
    const double a = 0.2 + 0.1 * uniform(random), b = 0.1 * uniform(random);
    std::vector<MeshAnswer> answers;
    for (const double h : {1.0, 0.5, 0.25, 0.125}) answers.push_back({h, 1 + a * h + b * h * h});
    const Extrapolation found = Extrapolate(answers);
    covered += std::abs(found.limit.value - 1) <= found.limit.bar ? 1 : 0;
    useful += found.limit.bar < 0.5 * std::abs(answers.back().value - 1) ? 1 : 0;
  }
  EXPECT_GE(covered, kCases * 95 / 100);
  EXPECT_GE(useful, kCases / 2) << "as small as that it is worth extrapolating";
}

TEST(RichardsonTest, NoiseIsNotExtrapolatedButSpread) {
  const std::vector<MeshAnswer> answers{{1, 1.0}, {0.5, 1.2}, {0.25, 1.1}};
  const Extrapolation found = Extrapolate(answers);
  EXPECT_EQ(found.limit.value, 1.1) << "the finest";
  EXPECT_DOUBLE_EQ(found.limit.bar, 0.2);
  EXPECT_TRUE(std::isnan(found.order));
}

TEST(RichardsonTest, DivergenceIsNotTakenForConvergence) {
  // Differences that grow under refinement, as of a point load in two dimensions.
  const Extrapolation found = Extrapolate({{1, 1.0}, {0.5, 1.1}, {0.25, 1.3}});
  EXPECT_TRUE(std::isnan(found.order));
  EXPECT_GE(found.limit.bar, 0.3 - 1e-12);
}

TEST(RichardsonTest, OfEqualSizesTheLastAnswerCounts) {
  const Extrapolation found = Extrapolate({{1, 1.4}, {0.5, 9}, {0.5, 1.2}, {0.25, 7}, {0.25, 1.1}});
  EXPECT_NEAR(found.limit.value, 1.0, 1e-9);
}

}  // namespace
}  // namespace palpate::study
