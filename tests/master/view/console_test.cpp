#include "master/view/console.h"

#include <cstdio>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/view/pinched_cube.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::ElementsAre;
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

TEST(StatusLineTest, TellsStateRateRoundTripAgeAndForceWithABar) {
  EXPECT_EQ(FormatStatus(Following()),
            "  12.3 s  FOLLOWING     1000 Hz  RTT  0.21 ms  age   3 ms   1.65 N "
            "[##########..........]");
}

TEST(StatusLineTest, SaysWhyTheForceWasChangedAndWhatTroublesTheLink) {
  SessionStatus status = Following();
  status.tick.chain.reasons.Add(Reason::kClamped);
  status.link.trouble = "the lease is held by anna";
  EXPECT_THAT(FormatStatus(status),
              AllOf(HasSubstr("clamped"), HasSubstr("(the lease is held by anna)")));
}

TEST(StatusLineTest, ShowsADashForWhatIsNotKnown) {
  EXPECT_THAT(FormatStatus(SessionStatus()),
              AllOf(HasSubstr("RTT     - ms"), HasSubstr("age   - ms")));
}

TEST(StatusLineTest, StaysALineWhateverTheNumbers) {
  SessionStatus status = Following();
  status.tick.chain.sent = {1e300, -1e300, std::nan("")};
  status.force_limit = 0;
  status.tick.state_age = 1e300;
  status.t = -1e300;
  EXPECT_THAT(FormatStatus(status), Not(HasSubstr("\n")));
}

// What a console writes into a file.
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

// What a terminal shows after `text`: knows the three controls that the console uses.
std::vector<std::string> Screen(const std::string& text) {
  std::vector<std::string> rows{""};
  std::size_t row = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\r') continue;  // every line is written whole
    if (text[i] == '\n') {
      if (++row == rows.size()) rows.emplace_back();
      rows[row].clear();
    } else if (text[i] == '\x1b') {
      const std::size_t end = text.find_first_of("AJK", i);
      if (text[end] == 'A') row -= std::stoul(text.substr(i + 2, end - i - 2));
      if (text[end] == 'A') rows[row].clear();
      if (text[end] == 'J') rows.resize(row + 1);
      i = end;
    } else {
      if (i > 0 && text[i - 1] == '\r') rows[row].clear();
      rows[row] += text[i];
    }
  }
  return rows;
}

TEST_F(ConsoleTest, OnATerminalTheTableOfFingersIsReplacedAsAWhole) {
  const ShapeMoment moment = PinchedCube(0.006);
  SessionStatus status = Following();
  status.fingers = moment.fingers;
  {
    Console console(file_, true);
    console.Show(status);
    console.Show(status, moment.mesh.get());
    console.Show(status, moment.mesh.get());
    status.fingers.pop_back();  // one finger: the status line tells of it
    status.fingers[0].contact.in_contact = false;
    console.Show(status);
    status.fingers = moment.fingers;
    console.Show(status, moment.mesh.get());
    console.Print("done");
  }
  EXPECT_THAT(Screen(Written()), ElementsAre(HasSubstr("FOLLOWING"), HasSubstr("ff       contact"),
                                             HasSubstr("th       contact"),
                                             HasSubstr("moved by up to 6 mm"), "done", ""));
}

TEST_F(ConsoleTest, InAPipeTheFingersStandBehindTheStatus) {
  const ShapeMoment moment = PinchedCube(0.006);
  SessionStatus status = Following();
  status.fingers = moment.fingers;
  Console console(file_, false);
  console.Show(status, moment.mesh.get());
  const std::string text = Written();
  EXPECT_EQ(Count(text, '\n'), 1);
  EXPECT_THAT(text, HasSubstr("  ff 0.423 N  th 0.401 N  moved 6 mm\n"));
}

}  // namespace
}  // namespace palpate
