#include "shared/state/verdict.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(VerdictTest, TheWorseValidityDecides) {
  Verdict verdict{Validity::kValid};
  verdict.Fail(FailedCheck::kModelRange, "range");
  verdict.Add({Validity::kTrackingLost, FailedCheck::kNone, "lost"});
  verdict.Fail(FailedCheck::kFrozen, "frozen");
  EXPECT_EQ(verdict.validity, Validity::kTrackingLost);
  EXPECT_EQ(verdict.check, FailedCheck::kNone);
  EXPECT_EQ(verdict.reason, "lost");
}

TEST(VerdictTest, TheHighestRankIsReportedInAnyOrder) {
  for (const bool reversed : {false, true}) {
    Verdict verdict{Validity::kValid};
    verdict.Fail(reversed ? FailedCheck::kIndentation : FailedCheck::kScale);
    verdict.Fail(reversed ? FailedCheck::kScale : FailedCheck::kIndentation);
    EXPECT_EQ(verdict.validity, Validity::kExtrapolated);
    EXPECT_EQ(verdict.check, FailedCheck::kScale) << reversed;
  }
}

}  // namespace
}  // namespace palpate
