#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slave/pipeline/offline/offline_report.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Two samples calculated by hand: errors 0.1 and -0.2; the model's parts are 0.3 and 0, those of
// tracking -0.2 and -0.2.
TEST(ErrorBudgetTest, SplitsTheErrorIntoModelAndTracking) {
  const ErrorBudget budget =
      BudgetOf({{{0, 1.1, 0}, {0, 1, 0}, 1.3}, {{0, 1.8, 0}, {0, 2, 0}, 2.0}});
  EXPECT_NEAR(budget.rms, std::sqrt((0.01 + 0.04) / 2), 1e-12);
  EXPECT_NEAR(budget.model_rms, std::sqrt(0.09 / 2), 1e-12);
  EXPECT_NEAR(budget.tracking_rms, 0.2, 1e-12);
  EXPECT_EQ(budget.peak_force, 2.0);
  EXPECT_NEAR(budget.peak_error, 0.2, 1e-12);
}

// A force of the right size that points the wrong way is an error: a 3-4-5 triangle, one newton
// times the square root of two.
TEST(ErrorBudgetTest, AWrongDirectionCounts) {
  const ErrorBudget budget = BudgetOf({{{0.6, 0.8, 0}, {-0.8, 0.6, 0}, 1.0}});
  EXPECT_NEAR(budget.rms, std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(budget.model_rms, 0, 1e-12);
  EXPECT_NEAR(budget.tracking_rms, 0, 1e-12);
}

// The third sample is without contact: true and estimated force are below a hundredth of the peak.
// The fourth counts as contact although the true force is zero; the last is unknown.
TEST(ErrorBudgetTest, OnlyKnownForcesInContactCount) {
  const ErrorBudget budget = BudgetOf({{{0, 2, 0}, {0, 2, 0}, 2.0},
                                       {{0, 2, 0}, {0, 1, 0}},
                                       {{0, 0.01, 0}, {0, 0.01, 0}, 7.0},
                                       {{0, 0.3, 0}, {0, 0, 0}, 0.0},
                                       {Vector3d::Constant(std::nan("")), {0, 4, 0}, 4.0}});
  EXPECT_EQ(budget.count, 3U);
  EXPECT_EQ(budget.peak_force, 4.0);
  EXPECT_NEAR(budget.rms, std::sqrt((1 + 0.09) / 3), 1e-12);
  EXPECT_NEAR(budget.tracking_rms, std::sqrt(0.09 / 2), 1e-12) << "the second has no model";
}

}  // namespace
}  // namespace palpate
