// Tests what a watch shows of slaves that publish, stop, or send invalid states.
#include "master/watch/fleet.h"

#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/telemetry.pb.h"

#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Time kFleetStart = Clock::now();
Time FleetTime(double seconds) {
  return kFleetStart + Seconds(seconds);
}

SlaveState PressedState() {
  SlaveState state;
  state.sequence = 1;
  // The slave's clock is an hour ahead: ages must not depend on it.
  state.sensed_at = FleetTime(3600);
  state.sent_at = FleetTime(3600.02);
  state.validity = Validity::kValid;
  state.force = Eigen::Vector3d(0, 3, 4);
  state.sigma = 0.25;
  state.phase = Phase::kFollowing;
  return state;
}

std::string BytesOf(const SlaveState& state) {
  v1::SlaveState message;
  ToProto(state, &message);
  return message.SerializeAsString();
}

std::string StatusOf(Time started, const std::string& alarm = "") {
  v1::Status status;
  ToProto(started, status.mutable_started_at());
  if (!alarm.empty()) status.add_alarms(alarm);
  return status.SerializeAsString();
}

SlaveLine Only(Fleet* fleet, Time now) {
  const auto lines = fleet->Lines(now);
  EXPECT_EQ(lines.size(), 1U);
  return lines.empty() ? SlaveLine{} : lines[0];
}

TEST(Fleet, ShowsForceValidityPhaseAndAgeOfTheNewestState) {
  Fleet fleet;
  fleet.Take("palpate.block.state", BytesOf(PressedState()), FleetTime(0));
  const SlaveLine line = Only(&fleet, FleetTime(0.1));
  EXPECT_EQ(line.name, "block");
  EXPECT_DOUBLE_EQ(line.force.value_or(0), 5);
  EXPECT_DOUBLE_EQ(line.sigma.value_or(0), 0.25);
  EXPECT_EQ(line.validity, "valid");
  EXPECT_EQ(line.phase, "following");
  EXPECT_NEAR(line.age.value_or(0), 0.12, 1e-6);
  EXPECT_NEAR(line.rate, 10, 1e-6);
  EXPECT_THAT(line.alarms, IsEmpty());
}

TEST(Fleet, ShowsEveryPhaseByItsName) {
  std::vector<std::string> shown;
  for (int phase = v1::PHASE_READY; phase <= v1::Phase_MAX; ++phase) {
    Fleet fleet;
    SlaveState state = PressedState();
    state.phase = static_cast<Phase>(phase);
    fleet.Take("palpate.block.state", BytesOf(state), FleetTime(0));
    shown.push_back(Only(&fleet, FleetTime(0.1)).phase);
  }
  EXPECT_THAT(shown,
              ElementsAre("ready", "following", "clutched", "hold", "estop", "observing", "setup"));
}

TEST(Fleet, ShowsNoForceThatIsUnknown) {
  Fleet fleet;
  SlaveState state = PressedState();
  state.validity = Validity::kStale;
  fleet.Take("palpate.block.state", BytesOf(state), FleetTime(0));
  const SlaveLine line = Only(&fleet, FleetTime(0.1));
  EXPECT_EQ(line.validity, "stale");
  EXPECT_FALSE(line.force);
}

TEST(Fleet, ShowsWhatIsNoStateAsUnreadable) {
  SlaveState far = PressedState();
  v1::SlaveState infinite;
  ToProto(far, &infinite);
  infinite.mutable_force()->set_x(std::numeric_limits<double>::infinity());
  for (const std::string& bytes : {std::string(100, '\0'), infinite.SerializeAsString()}) {
    Fleet fleet;
    fleet.Take("palpate.block.state", BytesOf(PressedState()), FleetTime(0));
    fleet.Take("palpate.block.state", bytes, FleetTime(0.1));
    const SlaveLine line = Only(&fleet, FleetTime(0.2));
    EXPECT_EQ(line.validity, "unreadable");
    EXPECT_FALSE(line.force);
    EXPECT_THAT(line.alarms, ElementsAre(HasSubstr("unreadable")));
  }
}

TEST(Fleet, ShowsAlarmsWithoutControlCharacters) {
  Fleet fleet;
  fleet.Take("palpate.block.status", StatusOf(FleetTime(-9), "driver\x1b[2J is silent"),
             FleetTime(0));
  fleet.Take("palpate.block.state", BytesOf(PressedState()), FleetTime(0));
  EXPECT_THAT(Only(&fleet, FleetTime(0.1)).alarms, ElementsAre("driver [2J is silent"));
  fleet.Take("palpate.block.status", StatusOf(FleetTime(-9)), FleetTime(1));
  fleet.Take("palpate.block.state", BytesOf(PressedState()), FleetTime(1));
  EXPECT_THAT(Only(&fleet, FleetTime(1.1)).alarms, IsEmpty());
}

TEST(Fleet, DistinguishesTwoSlavesOfOneNameFromARestart) {
  Fleet fleet;
  const auto publish = [&](double started) {
    fleet.Take("palpate.block.status", StatusOf(FleetTime(started)), FleetTime(0));
    fleet.Take("palpate.block.state", BytesOf(PressedState()), FleetTime(0));
  };
  publish(-9), publish(-5);
  EXPECT_THAT(Only(&fleet, FleetTime(0.1)).alarms, IsEmpty());
  publish(-9);
  EXPECT_THAT(Only(&fleet, FleetTime(0.2)).alarms,
              ElementsAre("two slaves publish with this name"));
}

TEST(Fleet, KeepsABoundedNumberAndIgnoresOtherSubjects) {
  Fleet fleet;
  for (const char* subject : {"other.a.state", "palpate.a.mesh", "palpate.state", ""})
    fleet.Take(subject, BytesOf(PressedState()), FleetTime(0));
  EXPECT_THAT(fleet.Lines(FleetTime(0)), IsEmpty());
  for (std::size_t i = 0; i < Fleet::kMaxSlaves + 10; ++i)
    fleet.Take("palpate.s" + std::to_string(i) + ".state", BytesOf(PressedState()), FleetTime(0));
  EXPECT_EQ(fleet.Lines(FleetTime(0)).size(), Fleet::kMaxSlaves);
}

}  // namespace
}  // namespace palpate
