#include "slave/pipeline/offline/error_budget.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

// Two pictures by hand: errors 0.1 and -0.2, of which the model 0.3 and 0, tracking -0.2 and -0.2.
TEST(ErrorBudgetTest, SplitsTheErrorIntoModelAndTracking) {
  ErrorBudget budget;
  budget.Add(1.1, 1.3, 1.0);
  budget.Add(1.8, 2.0, 2.0);
  EXPECT_NEAR(budget.rms(), std::sqrt((0.01 + 0.04) / 2), 1e-12);
  EXPECT_NEAR(budget.model_rms(), std::sqrt(0.09 / 2), 1e-12);
  EXPECT_NEAR(budget.tracking_rms(), 0.2, 1e-12);
  EXPECT_EQ(budget.peak_force(), 2.0);
  EXPECT_NEAR(budget.peak_error(), 0.2, 1e-12);
}

TEST(ErrorBudgetTest, AnEmptyOneIsZero) {
  EXPECT_EQ(ErrorBudget().rms(), 0);
}

// No error was measured, which is not an error of zero.
TEST(ErrorBudgetTest, AnEmptyOneIsNullInTheSummary) {
  EXPECT_TRUE(ToJson(ErrorBudget()).is_null());
  ErrorBudget budget;
  budget.Add(1.1, 1.3, 1.0);
  EXPECT_NEAR(ToJson(budget)["rms_N"], 0.1, 1e-12);
  EXPECT_EQ(ToJson(budget)["contact_frames"], 1);
}

}  // namespace
}  // namespace palpate
