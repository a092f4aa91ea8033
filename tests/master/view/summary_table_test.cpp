#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/view/console.h"

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(SummaryTableTest, SaysWhatAPersonWantsToKnow) {
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

TEST(SummaryTableTest, TellsOfFingersAndShapeWhereThereAreSome) {
  EXPECT_THAT(FormatSummary(Report()), testing::Not(HasSubstr("finger")));
  EXPECT_THAT(FormatSummary(Report()), testing::Not(HasSubstr("deflection")));
  Report report;
  report.fingers = {{"ff", 0.5, 0.42}, {"th", 0.25, 0.4}};
  report.shape = ShapeReport{37, 0.0063};
  const std::string text = FormatSummary(report);
  EXPECT_THAT(text,
              HasSubstr("finger ff              in contact 50 % of the time, at most 0.420 N"));
  EXPECT_THAT(text, HasSubstr("largest deflection     6.30 mm in 37 meshes"));
}

TEST(SummaryTableTest, SaysWhenTheTruthIsNotKnown) {
  const std::string text = FormatSummary(Report());
  EXPECT_THAT(text, HasSubstr("peak estimated force"));
  EXPECT_THAT(text, HasSubstr("reports no true force"));
}

TEST(SummaryTableTest, SurvivesNumbersOfAnySize) {
  Report report;
  report.force_peak = 1e300;
  report.energy_min = std::nan("");
  report.trouble = {std::string(500, 'x')};
  EXPECT_THAT(FormatSummary(report), HasSubstr("xxx"));
}

}  // namespace
}  // namespace palpate
