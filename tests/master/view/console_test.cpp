#include "master/view/console.h"

#include <cstdio>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/view/pinched_cube.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;

SessionStatus Following() {
  SessionStatus status;
  status.t = 12.3;
  status.tick.state = OperatorState::kFollowing;
  status.tick.state_age = 0.003;
  status.tick.chain.sent = {0, 1.65, 0};
  status.rate = 999.6;
  status.force_limit = 3.3;
  status.link.rtt_p50_us = 210;
  return status;
}

TEST(StatusLineTest, ShowsStateRateRoundTripAgeAndForceWithABar) {
  EXPECT_EQ(FormatStatus(Following()),
            "  12.3 s  FOLLOWING     1000 Hz  RTT  0.21 ms  age   3 ms   1.65 N "
            "[##########..........]");
}

TEST(StatusLineTest, StaysALineWhateverTheNumbers) {
  SessionStatus status = Following();
  status.tick.chain.sent = {1e300, -1e300, std::nan("")};
  status.force_limit = 0;
  status.tick.state_age = 1e300;
  status.t = -1e300;
  EXPECT_THAT(FormatStatus(status), Not(HasSubstr("\n")));
}

// Tests the text that a console writes to a file.
class ConsoleTest : public testing::Test {
 protected:
  void TearDown() override { std::fclose(file_); }
  std::string Written() {
    std::fflush(file_);
    std::rewind(file_);
    std::string text(1 << 16, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file_));
    return text;
  }
  static auto Count(const std::string& text, char wanted) {
    return std::count(text.begin(), text.end(), wanted);
  }

  std::FILE* file_ = std::tmpfile();
};

TEST_F(ConsoleTest, InAPipeALineEachSecondAndAtEachChange) {
  Console console(file_, false);
  SessionStatus status = Following();
  for (int i = 0; i < 50; ++i) {  // five seconds
    status.t = 0.1 * i;
    if (i == 25) status.tick.state = OperatorState::kHold;
    console.Show(status);
  }
  const std::string text = Written();
  EXPECT_EQ(Count(text, '\n'), 3 + 3);  // 0, 1, 2 | 2.5, 3.5, 4.5 s
  EXPECT_EQ(Count(text, '\r'), 0);
  EXPECT_EQ(Count(text, '\x1b'), 0);
  EXPECT_THAT(text, HasSubstr("HOLD"));
}

TEST_F(ConsoleTest, OnATerminalOneLineIsReplacedAndEndedBeforeOthers) {
  Console console(file_, true);
  for (int i = 0; i < 5; ++i) console.Show(Following());
  EXPECT_EQ(Count(Written(), '\n'), 0);
  std::fseek(file_, 0, SEEK_END);
  console.Print("done");
  const std::string text = Written();
  EXPECT_EQ(Count(text, '\r'), 5);
  EXPECT_THAT(text, HasSubstr("\ndone\n"));
}

}  // namespace
}  // namespace palpate
