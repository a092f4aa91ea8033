#include "master/station/moment_json.h"

#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "master/station/alarms.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

StationMoment PressedMoment() {
  StationMoment moment;
  moment.ticks.any = true;
  moment.ticks.t = 12.5;
  TickRecord& tick = moment.ticks.newest;
  tick.state = OperatorState::kFollowing;
  tick.sensed_age = 0.0625;
  tick.marks = 2;
  tick.render = RenderMode::kHold;
  tick.clutched = true;
  tick.chain.force_known = true;
  tick.chain.estimated = {0, 1.5, 0};
  tick.chain.sent = {0, 3.5, 0};
  tick.chain.reasons.Add(Reason::kClamped);
  moment.status.force_limit = 3.3;
  moment.slave_state.set_sequence(7);
  moment.slave_state.set_sigma(0.02F);
  moment.slave_state.set_validity(v1::VALIDITY_EXTRAPOLATED);
  moment.slave_state.mutable_details()->set_score(0.5F);
  return moment;
}

TEST(MomentJsonTest, ContainsTheValuesOfTheTick) {
  const Json json = Json::parse(StatusJson(PressedMoment()));
  EXPECT_EQ(json["kind"], "status");
  EXPECT_EQ(json["t"], 12.5);
  const Json& printed = json["tick"];
  EXPECT_EQ(printed["phase"], "OPERATOR_PHASE_FOLLOWING");
  EXPECT_EQ(printed["sent"], Json({{"x", 0}, {"y", 3.5}, {"z", 0}}));
  EXPECT_EQ(printed["reasons"], Json::array({"FORCE_REASON_CLAMPED"}));
  EXPECT_EQ(printed["marks"], 2);
  EXPECT_EQ(json["slave_state"]["validity"], "VALIDITY_EXTRAPOLATED");
  EXPECT_NEAR(json["slave_state"]["sigma"].get<double>(), 0.02, 1e-9);
  EXPECT_EQ(json["slave_state"]["details"]["score"], 0.5);
  EXPECT_EQ(json["link"]["sensed_age"], 0.0625);
  EXPECT_EQ(json["render"], "hold");
  EXPECT_TRUE(json["clutched"]);
  EXPECT_TRUE(json["replay"].is_null());
  EXPECT_TRUE(json["recording"].is_null()) << "none can be made";
}

// A state is no longer shown as the present one after a quarter of a second.
TEST(MomentJsonTest, DetailsThatAreTooOldAreUnknown) {
  StationMoment moment = PressedMoment();
  moment.status.fingers = {{"tool", {.force = Eigen::Vector3f(0, 1.5F, 0)}}};
  moment.slave_state.mutable_local_model()->set_revision(1);
  moment.slave_state.mutable_force()->set_y(1.5F);
  moment.slave_state_age = moment.ticks.newest.state_age = 0.2;
  LeaveOutOld(&moment);
  Json json = Json::parse(StatusJson(moment));
  EXPECT_TRUE(json["tick"].contains("estimated"));
  EXPECT_EQ(json["slave_state"]["details"]["score"], 0.5);
  moment.slave_state_age = moment.ticks.newest.state_age = 0.3;
  LeaveOutOld(&moment);
  json = Json::parse(StatusJson(moment));
  EXPECT_FALSE(json["tick"].contains("estimated"));
  EXPECT_EQ(json["slave_state"]["validity"], "VALIDITY_STALE");
  EXPECT_EQ(json["slave_state_age"], 0.3);
  for (const char* key : {"details", "local_model", "force", "moment"}) {
    EXPECT_FALSE(json["slave_state"].contains(key)) << key;
  }
  EXPECT_EQ(json["slave_state"]["sigma"], 0) << "no meaning without a force";
  EXPECT_TRUE(json["fingers"][0]["force"].is_null());
  EXPECT_EQ(json["fingers"][0]["validity"], "VALIDITY_STALE");
}

TEST(MomentJsonTest, TheLineIsLostConnectedDegradedOrGood) {
  StationMoment moment = PressedMoment();
  const auto link = [&moment](const char* key) {
    return Json::parse(StatusJson(moment))["link"][key].get<std::string>();
  };
  EXPECT_EQ(link("word"), "lost");
  EXPECT_EQ(link("role"), "");
  moment.status.link.answers = true;
  EXPECT_EQ(link("word"), "connected");
  EXPECT_EQ(link("role"), "observer") << "the lease is another's";
  moment.status.link.connected = true;
  EXPECT_EQ(link("word"), "good");
  EXPECT_EQ(link("role"), "operator");
  moment.ticks.late_share = 0.05;
  moment.ticks.rate = 780;
  EXPECT_EQ(link("word"), "degraded");
  EXPECT_EQ(link("why"), "5 % of the states late; haptic loop at 780 Hz");
  moment.ticks.newest.state = OperatorState::kDisconnected;
  EXPECT_EQ(link("word"), "connected") << "no states yet";
}

// A force of zero and an unknown force are different.
TEST(MomentJsonTest, WhatIsNotKnownIsNull) {
  StationMoment moment = PressedMoment();
  moment.ticks.newest.chain.force_known = false;
  moment.slave_state.set_sequence(0);
  const Json json = Json::parse(StatusJson(moment));
  EXPECT_FALSE(json["tick"].contains("estimated"));
  EXPECT_TRUE(json["slave_state"].is_null());
  EXPECT_TRUE(json["link"]["age"].is_null());
  EXPECT_TRUE(json["rate"].is_null());
}

// The slave's own report is passed on unchanged.
TEST(MomentJsonTest, TheSlavesHealthIsPrintedWithTheNamesOfProto) {
  SlaveHealth health;
  health.trouble = "no answer";
  Json json = Json::parse(HealthJson(health));
  EXPECT_TRUE(json["scene"].is_null());
  EXPECT_TRUE(AlarmsIn(health).empty());
  health.scene.emplace().mutable_material()->set_young_modulus(127e3);
  health.status.emplace().set_phase(v1::PHASE_HOLD);
  for (int i = 0; i < 12; ++i) health.status->add_alarms("a");
  json = Json::parse(HealthJson(health));
  EXPECT_EQ(json["trouble"], "no answer");
  EXPECT_EQ(json["scene"]["material"]["young_modulus"], 127e3);
  EXPECT_EQ(json["status"]["phase"], "PHASE_HOLD");
  EXPECT_EQ(AlarmsIn(health).size(), 8U);
}

// Reference: the layout of FieldTopology and Field in moment_json.h, read byte by byte.
TEST(MomentJsonTest, TheFieldComesWithItsPlaceInTheImage) {
  auto topology = std::make_shared<MeshTopology>();
  topology->field_rest = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  topology->field_triangles = {0, 1, 2};
  RemoteMesh mesh;
  mesh.validity = Validity::kFailed;
  mesh.topology = topology;
  mesh.displacement = {0, 0.25F, 0, 0, 0, 0, 0, 0, 0};
  const std::string fixed = FieldTopologyBytes(*topology), without = FieldBytes(mesh);
  mesh.image = {10, 20, 30, 20, 10, 0};
  const std::string with = FieldBytes(mesh);
  const auto integer = [](const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, &bytes.at(at), sizeof(value));
    return value;
  };
  const auto number = [](const std::string& bytes, std::size_t at) {
    float value = 0;
    std::memcpy(&value, &bytes.at(at), sizeof(value));
    return value;
  };
  ASSERT_EQ(fixed.size(), 8U + 36 + 12);
  EXPECT_EQ(integer(fixed, 0), 3U);
  EXPECT_EQ(integer(fixed, 4), 1U);
  EXPECT_EQ(number(fixed, 20), 1);
  EXPECT_EQ(integer(fixed, 52), 2U);
  ASSERT_EQ(without.size(), 8U + 36);
  EXPECT_EQ(integer(without, 0), 5U) << "no solution";
  EXPECT_EQ(integer(without, 4), 0U) << "no camera";
  ASSERT_EQ(with.size(), 8U + 36 + 24);
  EXPECT_EQ(integer(with, 4), 1U);
  EXPECT_EQ(number(with, 12), 0.25F);
  EXPECT_EQ(number(with, 48), 20);
}

TEST(MomentJsonTest, InvalidNumbersAndTextsGiveReadableJson) {
  StationMoment moment = PressedMoment();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  v1::SlaveState& state = moment.slave_state;
  state.set_sigma(std::numeric_limits<float>::quiet_NaN());
  state.mutable_details()->set_misfit(-kInfinity);
  for (const float number : {kInfinity, 1.0F, -kInfinity}) {
    state.mutable_local_model()->add_stiffness(number);
  }
  moment.status.link.trouble = "\xff\xfe \"quoted\" \n";
  const Json json = Json::parse(StatusJson(moment));
  EXPECT_TRUE(json["slave_state"]["sigma"].is_null());
  EXPECT_TRUE(json["slave_state"]["details"]["misfit"].is_null());
  EXPECT_EQ(json["slave_state"]["local_model"]["stiffness"], Json::array({nullptr, 1, nullptr}));
  EXPECT_NE(json["link"]["trouble"].get<std::string>().find("\"quoted\""), std::string::npos);
}

}  // namespace
}  // namespace palpate
