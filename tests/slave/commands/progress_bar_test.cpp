#include "slave/commands/progress_bar.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A terminal or a file that records its output, and a clock that the test advances.
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

TEST(ProgressBarTest, ShortWorkPrintsNothing) {
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

TEST(ProgressBarTest, TerminalIsDrawnTenTimesASecondAtMost) {
  Screen screen;
  ProgressBar bar("solve", {}, screen.Output());
  bar.Expect({.seconds = 10, .memory_bytes = 0});
  const std::size_t before = screen.writes.size();
  for (int i = 0; i < 10'000; ++i, screen.now += 1e-4) bar.Report("assembly", i * 1e-4);
  // In one second: the first output at once, then one every tenth of a second.
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

TEST(ProgressBarTest, StopIsPassedOnEvenWhenNothingIsDrawn) {
  Screen screen;
  std::stop_source stop;
  ProgressBar bar("solve", stop.get_token(), screen.Output());
  EXPECT_TRUE(bar.Report("assembly", 0.1));
  stop.request_stop();
  EXPECT_FALSE(bar.Report("assembly", 0.1));
}

}  // namespace
}  // namespace palpate
