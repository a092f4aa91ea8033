// Listening and the unary calls.
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/service/service_fixture.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class ServerTest : public ServiceTest {};

std::string WhyNot(FakeSlave* slave, const std::string& address, bool insecure = false) {
  return Thrown<std::runtime_error>([&] { const Server server(*slave, address, insecure); });
}

TEST_F(ServerTest, PlainTextIsServedOnLoopbackOnly) {
  FakeSlave other;
  EXPECT_THAT(WhyNot(&other, "0.0.0.0:0"), HasSubstr("without --insecure, expected a loopback"));
  EXPECT_EQ(WhyNot(&other, "0.0.0.0:0", true), "");
}

TEST_F(ServerTest, TheSceneIsDescribed) {
  grpc::ClientContext context;
  v1::SceneDescription scene;
  ASSERT_TRUE(Connect()->GetScene(&context, {}, &scene).ok());
  EXPECT_EQ(scene.name(), "spring-surface");
  EXPECT_EQ(scene.geometry(), "rectangle 88 mm x 88 mm, 9 mm thick");
  EXPECT_EQ(scene.material().young_modulus(), 127e3);
  EXPECT_EQ(scene.model().kind(), "spring");
  EXPECT_EQ(scene.model().reason(), "it is a fake");
  EXPECT_THAT(scene.operator_().orientation(), testing::ElementsAre(1, 0, 0, 0));
  EXPECT_EQ(scene.operator_().force_limit(), 3.3);
}

TEST_F(ServerTest, ErrorsOfTheSlaveArriveAsACodeAndTheSameSentence) {
  const auto stub = Connect();
  const auto set_model = [&](v1::Teleoperation::Stub& caller, const std::string& kind) {
    grpc::ClientContext context;
    v1::SetModelRequest request;
    request.set_kind(kind);
    v1::SettingsReply reply;
    return caller.SetModel(&context, request, &reply);
  };
  EXPECT_TRUE(set_model(*stub, "bem2d").ok());
  EXPECT_THAT(set_model(*stub, "magic"),
              EndedWith(grpc::StatusCode::INVALID_ARGUMENT, "kind = magic: expected bem2d"));

  Operator ada(Connect());
  ada.Hold(0);
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_FOLLOWING; }));
  EXPECT_THAT(set_model(ada.stub(), "bem2d"),
              EndedWith(grpc::StatusCode::FAILED_PRECONDITION, "an operator follows"));
}

// While an operator works, other clients cannot change anything, but anyone may stop the tool.
TEST_F(ServerTest, WhileSomebodyOperatesOnlyTheOperatorChangesSettings) {
  Operator ada(Connect());
  ada.Hold(0, "Ada");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 1; }));
  const auto stub = Connect();
  const auto refusals = [&](v1::Teleoperation::Stub& caller) {
    v1::SetParametersRequest softer;
    softer.set_young_modulus(1e13);
    v1::SettingsReply settings;
    v1::Status status;
    grpc::ClientContext for_parameters, for_reset, for_tracking;
    return std::vector{caller.SetParameters(&for_parameters, softer, &settings),
                       caller.Reset(&for_reset, {}, &status),
                       caller.ReinitializeTracking(&for_tracking, {}, &status)};
  };
  for (const grpc::Status& refused : refusals(*stub)) {
    EXPECT_THAT(
        refused,
        EndedWith(grpc::StatusCode::FAILED_PRECONDITION,
                  HasSubstr("only the operator may change settings: Ada (ipv4:127.0.0.1:")));
  }
  EXPECT_FALSE(slave_.parameters().young_modulus.has_value());
  EXPECT_EQ(slave_.reinitialized(), 0);
  for (const grpc::Status& answer : refusals(ada.stub())) EXPECT_TRUE(answer.ok());
  EXPECT_EQ(slave_.parameters().young_modulus, 1e13);
  EXPECT_TRUE(ada.Leave().ok());
  for (const grpc::Status& answer : refusals(*stub)) EXPECT_TRUE(answer.ok()) << "nobody operates";
}

}  // namespace
}  // namespace palpate
