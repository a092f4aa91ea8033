#include "slave/commands/progress_bar.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A terminal or a file that remembers, and a clock that stands still until it is moved.
struct Screen {
  bool is_terminal = true;
  int columns = 80;
  double now = 100;
  std::vector<std::string> writes = {};

  ProgressBar::Output Output() {
    return {is_terminal, columns, [this](std::string_view text) { writes.emplace_back(text); },
            [this] { return now; }};
  }
};

TEST(ProgressBarTest, WorkThatIsOverAtOnceSaysNothing) {
  for (const bool terminal : {true, false}) {
    Screen screen{.is_terminal = terminal};
    {
      ProgressBar bar("solve", {}, screen.Output());
      bar.Expect({.seconds = 0.1, .memory_bytes = 1000});
      for (int i = 0; i <= 40; ++i, screen.now += 0.01) bar.Report("assembly", i / 40.0);
    }
    EXPECT_THAT(screen.writes, IsEmpty());
  }
}

TEST(ProgressBarTest, SaysTheExpectedTimeAndMemoryFirst) {
  Screen screen;
  ProgressBar bar("solve", {}, screen.Output());
  bar.Expect({.seconds = 300, .memory_bytes = 2'500'000'000});
  EXPECT_THAT(screen.writes, ElementsAre("solve: expected 5.0 min and 2.5 GB of memory\n"));
}

TEST(ProgressBarTest, TerminalIsDrawnTenTimesASecondAtMost) {
  Screen screen;
  ProgressBar bar("solve", {}, screen.Output());
  bar.Expect({.seconds = 10, .memory_bytes = 0});
  const std::size_t before = screen.writes.size();
  for (int i = 0; i < 10'000; ++i, screen.now += 1e-4) bar.Report("assembly", i * 1e-4);
  // One second: the first at once, then one every tenth of a second.
  EXPECT_NEAR(static_cast<double>(screen.writes.size() - before), 10, 1);
}

TEST(ProgressBarTest, TimeLeftFollowsThePaceOfTheStage) {
  Screen screen;
  ProgressBar bar("solve", {}, screen.Output());
  bar.Expect({.seconds = 100, .memory_bytes = 0});
  bar.Report("assembly", 0);
  screen.now += 10;
  bar.Report("assembly", 0.25);
  // A quarter took 10 s: three quarters take 30 s.
  EXPECT_THAT(screen.writes.back(), HasSubstr(" 25 %, 30 s left"));
  EXPECT_THAT(screen.writes.back(), HasSubstr("solve: assembly [##########....")) << "10 of 40";
}

TEST(ProgressBarTest, LineFitsTheTerminal) {
  for (const int columns : {1, 10, 30, 50, 80, 300}) {
    Screen screen{.columns = columns};
    ProgressBar bar("solve", {}, screen.Output());
    bar.Expect({.seconds = 100, .memory_bytes = 0});
    screen.writes.clear();
    bar.Report("factorising the stiffness matrix", 0);
    screen.now += 10;
    bar.Report("factorising the stiffness matrix", 0.5);
    ASSERT_THAT(screen.writes, SizeIs(2));
    for (const std::string& text : screen.writes) {
      const std::string erase = "\r\x1b[K";
      EXPECT_LE(text.size() - erase.size(), static_cast<std::size_t>(std::max(columns - 1, 1)));
    }
  }
}

TEST(ProgressBarTest, FilesGetPlainLinesEveryTenthAndAtStageChanges) {
  Screen screen{.is_terminal = false};
  ProgressBar bar("study", {}, screen.Output());
  bar.Expect({.seconds = 10, .memory_bytes = 0});
  screen.writes.clear();
  for (int i = 0; i <= 1000; ++i, screen.now += 0.01) bar.Report("assembly", i * 1e-3);
  EXPECT_THAT(screen.writes, SizeIs(11)) << "0 to 100 %";
  bar.Report("solution", 0);
  EXPECT_EQ(screen.writes.back(), "study: solution   0 %\n");
  for (const std::string& text : screen.writes) {
    EXPECT_EQ(text.find_first_of("\r\x1b"), std::string::npos) << "control characters in a file";
  }
}

TEST(ProgressBarTest, StopIsPassedOnEvenWhenNothingIsDrawn) {
  Screen screen;
  std::stop_source stop;
  ProgressBar bar("solve", stop.get_token(), screen.Output());
  EXPECT_TRUE(bar.Report("assembly", 0.1));
  stop.request_stop();
  EXPECT_FALSE(bar.Report("assembly", 0.1));
}

TEST(ProgressBarTest, NonsenseSharesAreShownInsideTheScale) {
  Screen screen;
  ProgressBar bar("solve", {}, screen.Output());
  bar.Expect({.seconds = 10, .memory_bytes = 0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [done, shown] : {std::pair{nan, "  0 %"}, {-1.0, "  0 %"}, {7.0, "100 %"}}) {
    screen.now += 1;
    bar.Report("assembly", done);
    EXPECT_THAT(screen.writes.back(), HasSubstr(shown));
  }
}

TEST(ProgressBarTest, LeavesAnEmptyLineBehind) {
  Screen screen;
  {
    ProgressBar bar("solve", {}, screen.Output());
    bar.Expect({.seconds = 10, .memory_bytes = 0});
    bar.Report("assembly", 0.5);
  }
  EXPECT_EQ(screen.writes.back(), "\r\x1b[K");
}

}  // namespace
}  // namespace palpate
