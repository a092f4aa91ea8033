#include "master/station/moment_json.h"

#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "master/station/alarms.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

StationMoment Pressed() {
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
  tick.chain.sent = {0, 3.3, 0};
  tick.chain.reasons.Add(Reason::kClamped);
  moment.status.force_limit = 3.3;
  moment.observed.state.sequence = 7;
  moment.observed.state.sigma = 0.02;
  moment.observed.state.validity = Validity::kExtrapolated;
  moment.observed.details = R"({"score":0.97})";
  return moment;
}

TEST(MomentJsonTest, SaysWhatTheTickSays) {
  const Json json = Json::parse(StatusJson(Pressed()));
  EXPECT_EQ(json["kind"], "status");
  EXPECT_EQ(json["t"], 12.5);
  EXPECT_EQ(json["state"], "FOLLOWING");
  EXPECT_EQ(json["chain"]["sent"], Json::array({0, 3.3, 0}));
  EXPECT_EQ(json["chain"]["reasons"], Json::array({"clamped"}));
  EXPECT_EQ(json["slave_state"]["validity"], "VALIDITY_EXTRAPOLATED");
  EXPECT_NEAR(json["slave_state"]["sigma"].get<double>(), 0.02, 1e-9);
  EXPECT_EQ(json["slave_state"]["details"]["score"], 0.97);
  EXPECT_EQ(json["link"]["sensed_age"], 0.0625);
  EXPECT_EQ(json["marks"], 2);
  EXPECT_EQ(json["render"], "hold");
  EXPECT_TRUE(json["clutched"]);
  EXPECT_TRUE(json["replay"].is_null());
  EXPECT_TRUE(json["recording"].is_null()) << "none can be made";
}

// A state is no longer shown as the present one after a quarter of a second.
TEST(MomentJsonTest, WhatWasReportedTooLongAgoIsNotKnown) {
  StationMoment moment = Pressed();
  moment.status.fingers = {{"tool", {.force = Eigen::Vector3f(0, 1.5F, 0)}}};
  moment.observed.state.local_model.revision = 1;
  moment.observed_age = moment.ticks.newest.state_age = 0.2;
  LeaveOutOld(&moment);
  Json json = Json::parse(StatusJson(moment));
  EXPECT_FALSE(json["chain"]["estimated"].is_null());
  EXPECT_EQ(json["slave_state"]["details"]["score"], 0.97);
  moment.observed_age = moment.ticks.newest.state_age = 0.3;
  LeaveOutOld(&moment);
  json = Json::parse(StatusJson(moment));
  EXPECT_TRUE(json["chain"]["estimated"].is_null());
  EXPECT_EQ(json["slave_state"]["validity"], "VALIDITY_STALE");
  EXPECT_EQ(json["slave_state"]["age"], 0.3);
  for (const char* key : {"details", "local_model"}) {
    EXPECT_TRUE(json["slave_state"][key].is_null()) << key;
  }
  EXPECT_TRUE(json["fingers"][0]["force"].is_null());
  EXPECT_EQ(json["fingers"][0]["validity"], "stale");
}

TEST(MomentJsonTest, TheLineIsLostConnectedDegradedOrGood) {
  StationMoment moment = Pressed();
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

// Zero newtons and no news are two things.
TEST(MomentJsonTest, WhatIsNotKnownIsNull) {
  StationMoment moment = Pressed();
  moment.ticks.newest.chain.force_known = false;
  moment.observed.state.sequence = 0;
  const Json json = Json::parse(StatusJson(moment));
  EXPECT_TRUE(json["chain"]["estimated"].is_null());
  EXPECT_TRUE(json["slave_state"].is_null());
  EXPECT_TRUE(json["link"]["age"].is_null());
  EXPECT_TRUE(json["rate"].is_null());
}

TEST(MomentJsonTest, NumbersThatAreNoneAndWordsThatAreNoTextStayReadable) {
  StationMoment moment = Pressed();
  moment.ticks.newest.p_M = {std::numeric_limits<double>::quiet_NaN(), INFINITY, 0};
  moment.status.link.trouble = "\xff\xfe \"quoted\" \n";
  const Json json = Json::parse(StatusJson(moment));
  EXPECT_TRUE(json["p_M"][0].is_null());
  EXPECT_NE(json["link"]["trouble"].get<std::string>().find("\"quoted\""), std::string::npos);
}

}  // namespace
}  // namespace palpate
