#include "slave/checks/consistency.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

constexpr FailedCheck kOne = FailedCheck::kIndentation, kOther = FailedCheck::kArm;

// Reference: the quantile. Windows overlap, so failures occur in groups; at most ten times as many
// are accepted.
TEST(ConsistencyTest, NoiseOfTheStatedSizeFailsNoOftenerThanTheQuantile) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 2);
  Consistency consistency;
  int failed = 0;
  for (int i = 0; i < 100000; ++i) {
    consistency.Add({kOne, "x", noise(random), 2});
    consistency.Add({kOne, "y", noise(random), 2});
    failed += static_cast<int>(consistency.Close().verdict.validity != Validity::kValid);
  }
  EXPECT_LT(failed, 100);
}

TEST(ConsistencyTest, ASmallErrorThatLastsFailsAndIsNamed) {
  Consistency consistency;
  int samples = 0;
  Verdict verdict;
  do {
    consistency.Add({kOther, "well", 0, 1});
    consistency.Add({kOne, "less", 1, 1});
    consistency.Add({kOne, "more", -3, 1});
    verdict = consistency.Close().verdict;
  } while (++samples < 10 && verdict.validity == Validity::kValid);
  EXPECT_EQ(samples, 3);  // 30 is above the quantile for n = 6, 27.9; 20 below that for n = 4
  EXPECT_EQ(verdict.check, kOne);
  EXPECT_EQ(verdict.reason, "more");
}

TEST(ConsistencyTest, SigmaWidensByTheNormalisedSquare) {
  Consistency consistency;
  EXPECT_EQ(consistency.Close().widening, 1);
  consistency.Add({kOne, "x", 1, 2});
  EXPECT_EQ(consistency.Close().widening, 1);
  consistency.Add({kOther, "y", 5, 2});
  const Consistency::Result result = consistency.Close();
  EXPECT_EQ(result.verdict.check, FailedCheck::kNone);
  EXPECT_DOUBLE_EQ(result.widening, 2.5);
}

TEST(ConsistencyTest, WhatIsNotFiniteFailsWithoutAllocation) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Residual bad[] = {{kOne, "x", nan, 1},
                          {kOne, "x", 1, nan},
                          {kOne, "x", 1, 0},
                          {kOne, "x", 1, -1},
                          {kOne, "x", 1e300, 1e-300}};
  for (const Residual& residual : bad) {
    Consistency consistency;
    const long before = AllocationCount();
    consistency.Add(residual);
    const Consistency::Result result = consistency.Close();
    EXPECT_EQ(AllocationCount(), before);
    EXPECT_EQ(result.verdict.check, kOne) << residual.value << " / " << residual.sigma;
    EXPECT_EQ(result.widening, 1) << "a failed check does not change sigma";
  }
}

}  // namespace
}  // namespace palpate
