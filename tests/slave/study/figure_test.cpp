#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/study/report.h"
#include "tests/shared/text/well_formed.h"
#include "tests/slave/study/fake_model_factory.h"

namespace palpate::study {
namespace {

using testing::HasSubstr;

std::size_t Occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(FigureTest, ShowsEveryAnsweredRowInBothPanels) {
  fake::Scenario scenario;
  const StudyResult study = RunStudy(fake::Square(), {.timing_s = 1e-4}, scenario.Make());
  const std::string svg = DrawFigure(study);
  EXPECT_EQ(NotWellFormed(svg), "");
  for (const StudyRow& row : study.rows) {
    EXPECT_EQ(Occurrences(svg, ">" + row.family + ", " + row.resolution + ": error"), 2U);
  }
  EXPECT_THAT(svg, HasSubstr("class=\"front\""));
  EXPECT_THAT(svg, HasSubstr("class=\"target\""));
  EXPECT_EQ(Occurrences(svg, "class=\"choice\""), 3U) << "in both panels and in the legend";
  EXPECT_THAT(svg, HasSubstr("prefers-color-scheme: dark"));
}

TEST(FigureTest, StudyWithoutAnswersIsStillAPicture) {
  fake::Scenario scenario;
  scenario.stiffness = [](const Scene&) { return kUnknown; };
  const StudyResult study = RunStudy(fake::Square(), {.timing_s = 1e-4}, scenario.Make());
  EXPECT_EQ(NotWellFormed(DrawFigure(study)), "");
}

TEST(FigureTest, ErrorsOfZeroAndHugeOnesStayInsideThePicture) {
  fake::Scenario scenario;
  StudyResult study = RunStudy(fake::Square(), {.timing_s = 1e-4}, scenario.Make());
  study.rows[0].error = {0, 0};
  study.rows[1].error = {1e300, 1e300};
  study.rows[2].update_median_s = 1e-300;
  const std::string svg = DrawFigure(study);
  EXPECT_EQ(NotWellFormed(svg), "");
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

}  // namespace
}  // namespace palpate::study
