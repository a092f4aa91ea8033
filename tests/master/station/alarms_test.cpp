#include "master/station/alarms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/station/moment_json.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

auto HasText(const std::string& text) {
  return Field(&Alarm::text, HasSubstr(text));
}

StationMoment Good() {
  StationMoment moment;
  moment.status.link.connected = true;
  moment.status.force_limit = 3.3;
  moment.ticks.newest.state = OperatorState::kFollowing;
  moment.ticks.newest.state_age = 0.003;
  moment.slave_state.set_sequence(1);
  moment.slave_state.set_validity(v1::VALIDITY_VALID);
  return moment;
}

TEST(AlarmsTest, AFaultOfTheDeviceIsReportedWithNameCauseAndNextStep) {
  StationMoment moment = Good();
  moment.status.device = "touch: Touch";
  moment.ticks.newest.chain.reasons.Add(Reason::kBadDevice);
  moment.ticks.newest.device.fault = DeviceFault::kUnplugged;
  moment.ticks.newest.device.cause = "communication error";
  const std::vector<Alarm> alarms = AlarmsOf(moment);
  ASSERT_EQ(alarms.size(), 1U) << "what follows from it is not reported twice";
  EXPECT_EQ(alarms[0].level, Alarm::Level::kStop);
  EXPECT_EQ(alarms[0].text,
            "The device (touch: Touch): unplugged: communication error. Its force is zero.");
  EXPECT_THAT(alarms[0].next, HasSubstr("Plug the device in"));
}

TEST(AlarmsTest, ARecordingThatEndedAndOneThatFallsBehindNeedDifferentSteps) {
  StationMoment moment = Good();
  moment.recording = RecordingMoment{.on = true, .trouble = "a.mcap: the recording has ended"};
  const std::vector<Alarm> ended = AlarmsOf(moment);
  moment.recording->falls_behind = true;
  const std::vector<Alarm> behind = AlarmsOf(moment);
  ASSERT_EQ(ended.size(), 1U);
  ASSERT_EQ(behind.size(), 1U);
  EXPECT_THAT(ended[0].next, HasSubstr("--record-limit"));
  EXPECT_THAT(behind[0].next, HasSubstr("faster disk"));
}

// A lost slave is reported by one alarm, not by five.
TEST(AlarmsTest, ALostLineIsReportedOnce) {
  StationMoment moment = Good();
  moment.status.link.connected = false;
  moment.status.link.trouble = "no program listens there";
  moment.ticks.newest.state = OperatorState::kDisconnected;
  moment.ticks.newest.state_age = 2;
  moment.ticks.newest.chain.reasons.Add(Reason::kAged);
  moment.ticks.late_share = 0.5;
  moment.slave_state.set_validity(v1::VALIDITY_STALE);
  moment.health_trouble = "no answer in time";
  moment.frozen_for = 2;
  moment.slave_alarms = {"of before"};
  EXPECT_THAT(AlarmsOf(moment),
              ElementsAre(AllOf(HasText("No link to the slave: no program listens there."),
                                Field(&Alarm::next, HasSubstr("Is palpate-slave running?")))));
}

TEST(AlarmsTest, AFrozenImageIsReportedUnlessNothingIsSensed) {
  StationMoment moment = Good();
  moment.frozen_for = 2.4;
  EXPECT_THAT(AlarmsOf(moment), ElementsAre(HasText("The image has been frozen for 2 s.")));
  moment.slave_state.set_validity(v1::VALIDITY_STALE);
  EXPECT_THAT(AlarmsOf(moment), Not(Contains(HasText("The image"))));
}

// The operator's link is refused, so nobody operates; the slave's alarms are still reported.
TEST(AlarmsTest, ObserversSeeTheSlavesAlarmsWithoutAManipulator) {
  StationMoment moment = Good();
  moment.status.link = {.answers = true, .observes = true};
  moment.ticks.newest.state = OperatorState::kDisconnected;
  moment.ticks.newest.state_age = -1;
  moment.slave_alarms = {"no sample from the sensor for 6 s"};
  moment.slave_state.set_validity(v1::VALIDITY_STALE);
  EXPECT_THAT(AlarmsOf(moment), ElementsAre(HasText("The force is stale."),
                                            HasText("no sample from the sensor for 6 s")));
}

TEST(AlarmsTest, ASetUpHasNoForceToFlagButACameraThatMayBeSilent) {
  StationMoment moment = Good();
  moment.status.link = {.answers = true, .observes = true};
  moment.ticks.newest.state = OperatorState::kDisconnected;
  moment.slave_state.set_phase(v1::PHASE_SETUP);
  moment.slave_state.set_validity(v1::VALIDITY_FAILED);
  EXPECT_THAT(AlarmsOf(moment), ElementsAre());
  moment.frozen_for = 3;
  EXPECT_THAT(AlarmsOf(moment), ElementsAre(AllOf(HasText("The image has been frozen for 3 s."),
                                                  Field(&Alarm::next, HasSubstr("camera")))));
}

TEST(AlarmsTest, EveryChangeOfTheForceHasANextStep) {
  StationMoment moment = Good();
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    moment.ticks.newest.chain.reasons.Add(static_cast<Reason>(i));
  }
  const std::vector<Alarm> alarms = AlarmsOf(moment);
  EXPECT_THAT(alarms, Contains(HasText("The force was changed: the sample is too old.")));
  for (const Alarm& alarm : alarms) EXPECT_FALSE(alarm.next.empty()) << alarm.text;
}

}  // namespace
}  // namespace palpate
