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

}  // namespace
}  // namespace palpate
