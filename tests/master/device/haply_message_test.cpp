#include "master/device/haply/haply_message.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

const char* kState =
    R"({"session_id": 3, "inverse3": [{"device_id": "049D", "state": {
        "cursor_position": {"x": 0.01, "y": -0.02, "z": 0.03}, "cursor_velocity": {"x": 1, "y": 2, "z": 3},
        "current_cursor_force": {"x": 0, "y": 0, "z": 0.6}},
        "status": {"calibrated": false}, "config": {"filters": {"force_gate": {"gain": 0.3}}}}],
      "wireless_verse_grip": [{"device_id": "61576", "state": {
        "orientation": {"x": 0, "y": 0, "z": 1, "w": 0}, "buttons": {"a": true, "b": false, "c": true}},
        "status": {"awake": true}}]})";

TEST(HaplyMessageTest, ReadsPositionVelocityForceGripAndScaling) {
  const auto state = ParseHaplyState(kState);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->id, "049D");
  EXPECT_EQ(state->position, Eigen::Vector3d(0.01, -0.02, 0.03));
  EXPECT_EQ(*state->velocity, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(*state->force, Eigen::Vector3d(0, 0, 0.6));
  EXPECT_FALSE(state->calibrated);
  EXPECT_EQ(state->buttons, 0b101U);
  EXPECT_EQ(state->orientation->z(), 1);
  EXPECT_EQ(*state->gate_gain, 0.3);
}

TEST(HaplyMessageTest, AStateWithoutADeviceHasNoIdentifier) {
  const auto state = ParseHaplyState(R"({"inverse3": [], "verse_grip": []})");
  ASSERT_TRUE(state);
  EXPECT_EQ(state->id, "");
}

TEST(HaplyMessageTest, ASleepingGripPressesNothing) {
  std::string text = kState;
  text.replace(text.find("\"awake\": true"), 13, "\"awake\": false");
  EXPECT_EQ(ParseHaplyState(text)->buttons, 0U);
}

TEST(HaplyMessageTest, NonsenseIsNoState) {
  for (
      const char* text :
      {"", "{", "[]", "{}", "null", R"({"inverse3": 3})", R"({"inverse3": [{"device_id": "1"}]})",
       R"({"inverse3": [{"device_id": "1", "state": {"cursor_position": {"x": 1e999, "y": 0, "z": 0}}}]})",
       R"({"inverse3": [{"device_id": "1", "state": {"cursor_position": {"x": "0", "y": 0, "z": 0}}}]})"}) {
    EXPECT_FALSE(ParseHaplyState(text)) << text;
  }
}

TEST(HaplyMessageTest, WritesForcesInBothForms) {
  const auto written = [](HaplyForm form) {
    const auto json = nlohmann::json::parse(HaplyForceMessage("049D", {1.5, 0, -0.25}, form));
    EXPECT_EQ(json["inverse3"][0]["device_id"], "049D");
    return json["inverse3"][0]["commands"]["set_cursor_force"];
  };
  const auto axes = nlohmann::json::parse(R"({"x": 1.5, "y": 0.0, "z": -0.25})");
  EXPECT_EQ(written(HaplyForm::kValues), nlohmann::json({{"values", axes}}));
  EXPECT_EQ(written(HaplyForm::kVector), nlohmann::json({{"vector", axes}}));
  EXPECT_EQ(written(HaplyForm::kBoth), nlohmann::json({{"values", axes}, {"vector", axes}}));
}

// Reference: clients of 3.1 and 3.3 write `values`, the documentation of 3.5 `vector`.
TEST(HaplyMessageTest, ChoosesTheFormByTheRelease) {
  const auto form = [](const char* tag) {
    return HaplyFormOf(std::string(R"({"git_tag": ")") + tag + "\"}");
  };
  EXPECT_EQ(form("3.1.1"), HaplyForm::kValues);
  EXPECT_EQ(form("v3.0.4"), HaplyForm::kValues);
  EXPECT_EQ(form("3.3.2"), HaplyForm::kValues);
  EXPECT_EQ(form("3.4.0"), HaplyForm::kBoth);
  EXPECT_EQ(form("3.5.0"), HaplyForm::kVector);
  EXPECT_EQ(form("3.10.0"), HaplyForm::kVector);
  EXPECT_EQ(form("4.0.0"), HaplyForm::kVector);
  EXPECT_EQ(HaplyFormOf(R"({"project_version": "3.1.1.0"})"), HaplyForm::kValues);
  EXPECT_EQ(HaplyFormOf("{}"), HaplyForm::kBoth);
  EXPECT_EQ(HaplyFormOf("<html>"), HaplyForm::kBoth);
}

// Of a VerseGrip with a cable, which has one button.
TEST(HaplyMessageTest, ReadsAGripWithACable) {
  const char* text = R"({"inverse3": [{"device_id": "1", "state": {
        "cursor_position": {"x": 0, "y": 0, "z": 0}}}], "wireless_verse_grip": [],
      "verse_grip": [{"device_id": "2", "state": {"button": true, "hall": 1,
        "orientation": {"w": 0, "x": 1, "y": 0, "z": 0}}}]})";
  const auto state = ParseHaplyState(text);
  ASSERT_TRUE(state);
  EXPECT_TRUE(state->has_grip);
  EXPECT_EQ(state->buttons, 1U);
  EXPECT_EQ(state->orientation->x(), 1);
}

TEST(HaplyMessageTest, CountsSessionsAndReadsTheGlobalScale) {
  const auto sessions = ParseHaplySessions(R"({"sessions": [{}, {}], "force_scale": 0.5})");
  ASSERT_TRUE(sessions);
  EXPECT_EQ(sessions->count, 2U);
  EXPECT_EQ(sessions->force_scale, 0.5);
  EXPECT_FALSE(ParseHaplySessions("{}"));
}

}  // namespace
}  // namespace palpate
