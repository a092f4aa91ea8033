#include "master/device/haply/haply_message.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

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
