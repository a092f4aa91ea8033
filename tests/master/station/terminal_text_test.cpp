#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/station/terminal.h"

namespace palpate {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

StationHello Hello() {
  StationHello hello;
  hello.scene.name = "block";
  hello.scene.model = "bem2d";
  hello.target = "10.0.0.7:50051";
  hello.encrypted = true;
  return hello;
}

StationMoment Pressed() {
  StationMoment moment;
  moment.ticks.any = true;
  moment.ticks.t = 12.5;
  moment.ticks.rate = 1000;
  moment.ticks.round_trip = 0.0004;
  TickRecord& tick = moment.ticks.newest;
  tick.state = OperatorState::kFollowing;
  tick.state_age = 0.003;
  tick.chain.force_known = true;
  tick.chain.estimated = {0, 1.5, 0};
  tick.chain.limited = tick.chain.sent = {0, 3.3, 0};
  tick.chain.reasons.Add(Reason::kClamped);
  moment.status.force_limit = 3.3;
  moment.status.link.connected = true;
  moment.felt.state.sequence = 7;
  moment.felt.state.sigma = 0.02;
  moment.felt.state.validity = Validity::kValid;
  return moment;
}

std::string TextOf(const StationMoment& moment, const TerminalLook& look = {}) {
  std::string text;
  for (const std::string& line : TerminalText(Hello(), moment, {}, look)) text += line + "\n";
  return text;
}

TEST(TerminalTextTest, TellsTheEssentialsInWords) {
  const std::string text = TextOf(Pressed(), {120, 40, false});
  EXPECT_THAT(text, HasSubstr("palpate LIVE  block  bem2d  slave 10.0.0.7:50051 (TLS)"));
  EXPECT_THAT(text, HasSubstr("FOLLOWING         12.5 s"));
  EXPECT_THAT(text, HasSubstr("link   good  as operator"));
  EXPECT_THAT(text, HasSubstr("3.30 N of 3.30 N [##############################]"));
  EXPECT_THAT(text, HasSubstr("slave  1.500 N  sigma 0.020 N  valid"));
  EXPECT_THAT(text, HasSubstr("changed by clamped"));
  EXPECT_THAT(text, HasSubstr("round trip 0.40 ms"));
  EXPECT_THAT(text, HasSubstr("age 3 ms"));
  EXPECT_THAT(text, HasSubstr("loop   1000 Hz  missed 0  rendering local"));
  EXPECT_THAT(text, HasSubstr("note:  The force was changed: the force limit."));
  EXPECT_THAT(text, HasSubstr("       Press less: a larger force cannot be rendered."));
}

TEST(TerminalTextTest, WhatIsNotKnownIsNoNumber) {
  StationMoment moment = Pressed();
  moment.ticks.newest.chain.force_known = false;
  moment.ticks.newest.state_age = -1;
  moment.ticks.round_trip = 0;
  const std::string text = TextOf(moment, {120, 40, false});
  EXPECT_THAT(text, HasSubstr("slave  -  sigma -"));
  EXPECT_THAT(text, HasSubstr("round trip -"));
  EXPECT_THAT(text, HasSubstr("age -"));
}

TEST(TerminalTextTest, TellsTheStateOfTheDevice) {
  StationMoment moment = Pressed();
  moment.ticks.newest.device.calibration = Calibration::kCalibrated;
  moment.ticks.newest.device.output = DeviceOutput::kSaturated;
  moment.ticks.newest.device.buttons = 1;
  EXPECT_THAT(TextOf(moment), HasSubstr("calibrated, output saturated, buttons 1"));
  moment.ticks.newest.device.fault = DeviceFault::kHot;
  EXPECT_THAT(TextOf(moment), HasSubstr("device   hot"));
}

TEST(TerminalTextTest, AnAlarmSaysItsNextStep) {
  StationMoment moment = Pressed();
  moment.status.link.connected = false;
  moment.status.link.trouble = "refused";
  moment.ticks.newest.state = OperatorState::kDisconnected;
  const std::string text = TextOf(moment, {200, 40, false});
  EXPECT_THAT(text, HasSubstr("STOP:  No link to the slave: refused.\n       Is palpate-slave"));
}

TEST(TerminalTextTest, ColourIsNeverTheOnlyMark) {
  StationMoment moment = Pressed();
  moment.ticks.newest.state = OperatorState::kEstop;
  const std::string plain = TextOf(moment, {100, 40, false});
  EXPECT_THAT(plain, Not(HasSubstr("\x1b")));
  std::string coloured = TextOf(moment, {100, 40, true});
  EXPECT_THAT(coloured, HasSubstr("\x1b[1;31mESTOP"));
  for (std::size_t at; (at = coloured.find('\x1b')) != std::string::npos;) {
    coloured.erase(at, coloured.find('m', at) - at + 1);
  }
  EXPECT_EQ(coloured, plain);
}

TEST(TerminalTextTest, FitsTheTerminalAndKeepsTheKeys) {
  const auto lines = TerminalText(Hello(), Pressed(), {}, {40, 6, false});
  EXPECT_THAT(lines, SizeIs(6));
  EXPECT_THAT(lines, Each(SizeIs(testing::Le(40U))));
  EXPECT_THAT(lines.back(), HasSubstr("STOP"));
}

// What a slave says of itself must not move the cursor.
TEST(TerminalTextTest, StrangersWordsMoveNoCursor) {
  StationMoment moment = Pressed();
  moment.slave_alarms = {"\x1b[2J\x1b]0;owned\x07"};
  EXPECT_THAT(TextOf(moment, {100, 40, false}), Not(HasSubstr("\x1b")));
}

TEST(WishOfKeyTest, EveryKeyThatIsNotKnownStops) {
  const StationMoment moment = Pressed();
  for (const char key : {' ', '\n', '\x1b', 'x', 'R', '\0', '\x7f'}) {
    EXPECT_TRUE(std::holds_alternative<StopCommand>(*CommandOfKey(key, moment))) << int{key};
  }
  EXPECT_FALSE(CommandOfKey('q', moment));
  EXPECT_TRUE(std::holds_alternative<ResetCommand>(*CommandOfKey('r', moment)));
  EXPECT_TRUE(std::holds_alternative<MarkCommand>(*CommandOfKey('m', moment)));
  EXPECT_TRUE(std::holds_alternative<TareCommand>(*CommandOfKey('n', moment)));
}

TEST(WishOfKeyTest, TheOthersGoToAndFro) {
  StationMoment moment = Pressed();
  EXPECT_TRUE(std::get<ClutchCommand>(*CommandOfKey('c', moment)).on);
  moment.ticks.newest.clutched = true;
  EXPECT_FALSE(std::get<ClutchCommand>(*CommandOfKey('c', moment)).on);
  EXPECT_EQ(std::get<RenderCommand>(*CommandOfKey('v', moment)).mode, RenderMode::kInterpolate);
  moment.ticks.newest.render = RenderMode::kHold;
  EXPECT_EQ(std::get<RenderCommand>(*CommandOfKey('v', moment)).mode, RenderMode::kLocal);
  EXPECT_TRUE(std::get<RecordCommand>(*CommandOfKey('b', moment)).on);
  moment.recording = RecordingMoment{true, 1, {}};
  EXPECT_FALSE(std::get<RecordCommand>(*CommandOfKey('b', moment)).on);
}

}  // namespace
}  // namespace palpate
