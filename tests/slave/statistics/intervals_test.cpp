#include "slave/statistics/intervals.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Reference: tables of Student's t, 97.5 %.
TEST(IntervalsTest, StudentReachIsThatOfTheTables) {
  EXPECT_NEAR(StudentReach(2), 4.303, 1e-3);
  EXPECT_NEAR(StudentReach(10), 2.228, 1e-3);
  EXPECT_NEAR(StudentReach(1e6), 1.960, 1e-3);
}

// Reference: closed forms for none and all of n, 1 - 0.025^(1/n); 7 of 10 from the tables of
// Clopper and Pearson (1934).
TEST(IntervalsTest, ShareIntervalIsThatOfClopperAndPearson) {
  const double end = 1 - std::pow(0.025, 1.0 / 10);
  EXPECT_DOUBLE_EQ(ShareInterval(0, 10).low, 0);
  EXPECT_NEAR(ShareInterval(0, 10).high, end, 1e-9);
  EXPECT_NEAR(ShareInterval(1, 10).low, 1 - end, 1e-9);
  EXPECT_DOUBLE_EQ(ShareInterval(1, 10).high, 1);
  EXPECT_NEAR(ShareInterval(0.7, 10).low, 0.348, 1e-3);
  EXPECT_NEAR(ShareInterval(0.7, 10).high, 0.933, 1e-3);
}

TEST(IntervalsTest, AShareBetweenTwoCountsHasTheWiderInterval) {
  const Interval between = ShareInterval(0.65, 10);
  EXPECT_DOUBLE_EQ(between.low, ShareInterval(0.6, 10).low);
  EXPECT_DOUBLE_EQ(between.high, ShareInterval(0.7, 10).high);
}

}  // namespace
}  // namespace palpate
