#include "master/station/server/page_command.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(PageCommandTest, ReadsWhatThePageSends) {
  EXPECT_TRUE(std::holds_alternative<StopCommand>(ReadPageCommand(R"({"do":"stop"})")));
  EXPECT_TRUE(std::holds_alternative<ResetCommand>(ReadPageCommand(R"({"do":"reset"})")));
  EXPECT_EQ(std::get<PingCommand>(ReadPageCommand(R"({"do":"ping","at":12.5})")).at, 12.5);
  EXPECT_TRUE(std::holds_alternative<PastCommand>(ReadPageCommand(R"({"do":"past"})")));
  EXPECT_EQ(std::get<ModelCommand>(ReadPageCommand(R"({"do":"model","kind":"fem-green"})")).kind,
            "fem-green");
  const auto set = std::get<MappingCommand>(ReadPageCommand(R"({"do":"set","force_scale":2})"));
  EXPECT_EQ(set.force_scale, 2);
  EXPECT_FALSE(set.position_scale || set.force_limit);
  const auto pointer = std::get<PointerCommand>(
      ReadPageCommand(R"({"do":"pointer","at":3,"p_M":[0.1,-0.2,0.3],"engaged":true})"));
  EXPECT_EQ(pointer.p_M, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_TRUE(pointer.engaged);
  EXPECT_EQ(pointer.gap, 0);
  EXPECT_EQ(std::get<PointerCommand>(
                ReadPageCommand(R"({"do":"pointer","at":3,"p_M":[0,0,0],"gap":0.3})"))
                .gap,
            0.3);
  EXPECT_TRUE(std::holds_alternative<MarkCommand>(ReadPageCommand(R"({"do":"mark"})")));
  EXPECT_TRUE(std::holds_alternative<TareCommand>(ReadPageCommand(R"({"do":"tare"})")));
  EXPECT_TRUE(
      std::holds_alternative<ReinitializeTrackingCommand>(ReadPageCommand(R"({"do":"find"})")));
  EXPECT_FALSE(std::get<ClutchCommand>(ReadPageCommand(R"({"do":"clutch","on":false})")).on);
  EXPECT_TRUE(std::get<RecordCommand>(ReadPageCommand(R"({"do":"record","on":true})")).on);
  EXPECT_EQ(std::get<RenderCommand>(ReadPageCommand(R"({"do":"render","mode":"hold"})")).mode,
            RenderMode::kHold);
  const auto replay =
      std::get<ReplayCommand>(ReadPageCommand(R"({"do":"replay","speed":0.5,"to":-1})"));
  EXPECT_EQ(replay.speed, 0.5);
  EXPECT_EQ(replay.to, -1);
  EXPECT_FALSE(replay.playing);
}

// A pointer message without an explicit engagement does not engage.
TEST(PageCommandTest, EngagingIsExplicit) {
  EXPECT_FALSE(std::get<PointerCommand>(ReadPageCommand(R"({"do":"pointer","at":3,"p_M":[0,0,0]})"))
                   .engaged);
}

TEST(PageCommandTest, RefusesTheRest) {
  for (const char* message :
       {"", "stop", "{}", R"({"do":null})", R"({"do":"ping","at":null})",
        R"({"do":"pointer","at":1,"engaged":true})",
        R"({"do":"pointer","at":1,"p_M":[0,0,"0"],"engaged":true})",
        R"({"do":"pointer","at":1,"p_M":[0,0,11],"engaged":true})",
        R"({"do":"pointer","at":1,"p_M":[0,0,0],"engaged":"yes"})",
        R"({"do":"pointer","at":1,"p_M":[0,0,0],"gap":-1})",
        R"({"do":"pointer","at":1,"p_M":[0,0,0],"gap":"1"})", R"({"do":"set","force_limit":-1})",
        R"({"do":"clutch","on":1})", R"({"do":"record"})", R"({"do":"render","mode":1})",
        R"({"do":"replay","speed":0})", R"({"do":"model","kind":"fem; rm"})", "\xff\xfe",
        R"({"do":"stop")"}) {
    EXPECT_THROW(ReadPageCommand(message), std::invalid_argument) << message;
  }
  EXPECT_THROW(ReadPageCommand(R"({"do":"model","kind":")" + std::string(41, 'a') + "\"}"),
               std::invalid_argument);
  EXPECT_THROW(
      ReadPageCommand(R"({"do":"stop","x":")" + std::string(kMaxCommandBytes, 'a') + "\"}"),
      std::invalid_argument);
}

}  // namespace
}  // namespace palpate
