
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/view/console.h"

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(SummaryTableTest, ShowsTicksForceErrorAndStatesOfASession) {
  Report report;
  report.scene = "silicone-block";
  report.duration = 20;
  report.ticks = 19990;
  report.missed = 10;
  report.force_peak = 2.0;
  report.truth_known = true;
  report.force_error = ForceError::Summary{0.05, 0.1, 7000};
  report.clamped_ticks = 3;
  report.seconds_in = {{"FOLLOWING", 17.5}, {"READY", 2.5}};
  const std::string text = FormatSummary(report);
  for (const char* part : {"silicone-block", "20.0 s", "999.5 Hz, 10 of 20000 periods missed",
                           "peak true force", "2.000 N", "rms 0.0500 N = 2.50 % of the peak",
                           "7000 ticks", "FOLLOWING 17.5 s, READY 2.5 s", "3, 0"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

}  // namespace
}  // namespace palpate
