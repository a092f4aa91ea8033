// Tests Operate: the lease, received commands, sent states, and every way in which the stream may
// end.

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

using testing::HasSubstr;

struct OperateTest : ServiceTest {
  Operator ada{Connect()};
};

v1::OperatorCommand WithTorque(std::uint64_t sequence, bool torque) {
  v1::OperatorCommand command;
  command.set_sequence(sequence);
  command.set_torque(torque);
  return command;
}

// The moment is sent from the command on that requests it, until one does not. A client without
// this field gets states as before.
TEST_F(OperateTest, TheMomentIsSentToAnOperatorThatRequestsIt) {
  const auto has_none = [](const auto& s) { return !s.has_moment() && s.moment_sigma() == 0; };
  ASSERT_TRUE(ada.Send(WithTorque(1, false)));
  for (int i = 0; i < 5; ++i) {
    const auto state = ada.Read();
    ASSERT_TRUE(state.has_value());
    EXPECT_TRUE(has_none(*state));
  }
  ASSERT_TRUE(ada.Send(WithTorque(2, true)));
  const auto state = ada.ReadUntil([](const auto& s) { return s.has_moment(); });
  ASSERT_TRUE(state.has_value());
  EXPECT_EQ(state->moment().z(), 2e-3F);
  EXPECT_EQ(state->moment_sigma(), 1e-4F);
  ASSERT_TRUE(ada.Send(WithTorque(3, false)));
  EXPECT_TRUE(ada.ReadUntil(has_none));
}

// Reference: proto/README.md: repeated with unchanged sensed_at when nothing new was sensed.
TEST_F(OperateTest, StatesAreRepeatedWhileNothingIsSensed) {
  const auto first = ada.Read();
  const auto second = ada.Read();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->sensed_at().nanos(), second->sensed_at().nanos());
  EXPECT_NE(first->sent_at().nanos(), second->sent_at().nanos());
}

TEST_F(OperateTest, AnEmergencyStopIsReportedToTheOperatorAndItsReasonShortened) {
  ada.Hold(0);
  // Events are discarded while no client reads states.
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 1; }));
  CallContext context;
  v1::StopRequest request;
  request.set_reason(std::string(300, 'r'));
  v1::Status reply;
  ASSERT_TRUE(Connect()->Stop(&context, request, &reply).ok());
  EXPECT_EQ(reply.phase(), v1::PHASE_ESTOP);
  EXPECT_EQ(slave_.stop_reason(), std::string(200, 'r'));
  EXPECT_TRUE(ada.ReadUntil(
      [&](const auto& s) { return s.phase() == v1::PHASE_ESTOP && s.stops() == reply.stops(); }));
}

TEST_F(OperateTest, AStopInACommandActsWhateverTheRestContains) {
  ada.Hold(0, "Ada");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_FOLLOWING; }));
  v1::OperatorCommand broken;  // without sequence and position
  broken.mutable_p_m()->set_x(std::numeric_limits<double>::quiet_NaN());
  broken.set_stop(true);
  ada.Send(broken);
  EXPECT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_ESTOP; }));
  EXPECT_THAT(slave_.stop_reason(), HasSubstr("by the operator, Ada (ipv4:127.0.0.1:"));
}

}  // namespace
}  // namespace palpate
