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

TEST(VerdictTest, OfEqualRanksTheFirstReasonStays) {
  Verdict verdict{Validity::kValid};
  verdict.Fail(FailedCheck::kIndentation, "first");
  verdict.Fail(FailedCheck::kIndentation, "second");
  EXPECT_EQ(verdict.reason, "first");
}

TEST(VerdictTest, EachCheckHasARankOfItsOwn) {
  std::array<int, kFailedChecks> count{};
  for (int i = 0; i < kFailedChecks; ++i) {
    ++count[static_cast<std::size_t>(Rank(static_cast<FailedCheck>(i)))];
  }
  for (const int one : count) EXPECT_EQ(one, 1);
  EXPECT_EQ(Rank(FailedCheck::kNone), 0);
}

}  // namespace
}  // namespace palpate
