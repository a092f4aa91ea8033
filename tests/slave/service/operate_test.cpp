// Operate: the lease, commands in, states out, and every way it may end.

#include <csignal>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/slave/service/service_fixture.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using testing::HasSubstr;

struct OperateTest : ServiceTest {
  Operator ada{Connect()};
};
using NoOperatorTest = ServiceTest;

// Reference: the fake's spring, 1000 N/m, from 6 mm above it: 9 mm down press 3 mm, 3 N upwards.
TEST_F(OperateTest, PushingIsAnsweredByTheForceOfTheSurface) {
  ada.Hold(0);
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_FOLLOWING; }));
  ada.Hold(-9e-3);
  ASSERT_TRUE(Eventually([&] { return slave_.commands().size() == 2; }));
  slave_.TakeSample();
  const auto pressed = ada.ReadUntil([](const auto& s) { return s.force().y() > 0; });
  ASSERT_TRUE(pressed.has_value());
  EXPECT_NEAR(pressed->force().y(), 3, 1e-9);
  EXPECT_NEAR(pressed->p_s_tip().y(), -3e-3, 1e-12);
  EXPECT_EQ(pressed->command_sequence(), 2U);
  EXPECT_EQ(pressed->echo().seconds(), 1'700'000'000);
  EXPECT_TRUE(ada.Leave().ok());
  EXPECT_EQ(slave_.ends(), 1);
}

v1::OperatorCommand WithTorque(std::uint64_t sequence, bool torque) {
  v1::OperatorCommand command;
  command.set_sequence(sequence);
  command.set_torque(torque);
  return command;
}

// From the command on that requests it, and until one no longer does. A client that does not know
// of it gets states as before.
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

// Reference: contracts: repeated with unchanged sensed_at when nothing new was sensed.
TEST_F(OperateTest, StatesAreRepeatedWhileNothingIsSensed) {
  const auto first = ada.Read();
  const auto second = ada.Read();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->sensed_at().nanos(), second->sensed_at().nanos());
  EXPECT_NE(first->sent_at().nanos(), second->sent_at().nanos());
}

TEST_F(OperateTest, ASecondOperatorIsRefusedWithTheHolderOfTheLease) {
  ada.Hold(0, "Ada at the window");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 1; }));
  const grpc::Status refused = Operator(Connect()).Finish();
  EXPECT_THAT(refused, EndedWith(grpc::StatusCode::FAILED_PRECONDITION,
                                 HasSubstr("Ada at the window (ipv4:127.0.0.1:")));
  EXPECT_EQ(slave_.begins(), 1);
  EXPECT_EQ(GetStatus().operator_name(), "Ada at the window");
  EXPECT_THAT(GetStatus().alarms(), testing::Contains(HasSubstr("was refused: the lease is held")));
  EXPECT_TRUE(ada.Read().has_value()) << "the holder was disturbed";
}

TEST_F(OperateTest, AnEvictedOperatorsStreamEnds) {
  ada.Hold(0, "Ada");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 1; }));
  const auto stub = Connect();
  const auto evict = [&] {
    CallContext context;
    v1::EvictOperatorRequest request;
    request.set_reason("maintenance");
    v1::Status reply;
    return stub->EvictOperator(&context, request, &reply);
  };
  ASSERT_TRUE(evict().ok());
  EXPECT_EQ(slave_.ends(), 1);
  EXPECT_THAT(ada.Finish(),
              EndedWith(grpc::StatusCode::ABORTED, "evicted by an administrator: maintenance"));
  EXPECT_EQ(evict().error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

// A program that is killed says no goodbye: its connection just breaks.
TEST_F(NoOperatorTest, AfterTheOperatorsProgramWasKilledItGetsTheLeaseAgain) {
  std::string program = BinaryPath("/bin/lone_operator"), address = server_->address();
  char* const arguments[] = {program.data(), address.data(), nullptr};
  pid_t pid = 0;
  ASSERT_EQ(posix_spawn(&pid, program.c_str(), nullptr, nullptr, arguments, environ), 0);
  const bool operated = Eventually([&] { return !slave_.commands().empty(); });
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
  ASSERT_TRUE(operated);
  EXPECT_TRUE(Eventually([&] { return slave_.ends() == 1; }));
  Operator again(Connect());
  again.Hold(0, "lone");
  EXPECT_TRUE(again.Read().has_value());
}

TEST_F(OperateTest, NotFiniteAndAbsurdCommandsAreCountedReportedAndNotFollowed) {
  ada.Hold(0);
  v1::OperatorCommand command;
  command.set_sequence(2);
  command.set_epoch(1);
  command.set_engaged(true);
  for (const double absurd : {std::numeric_limits<double>::quiet_NaN(), -HUGE_VAL, 1e300, 1e5}) {
    command.set_sequence(command.sequence() + 1);
    command.mutable_p_m()->set_y(absurd);
    ada.Send(command);
    const auto state =
        ada.ReadUntil([](const auto& s) { return HasEvent(s, v1::EVENT_COMMAND_REFUSED); });
    ASSERT_TRUE(state.has_value()) << absurd;
    EXPECT_EQ(state->p_s_tip().y(), FakeSlave::kHome) << absurd;
  }
  EXPECT_EQ(GetStatus().commands_refused(), 4U);
  EXPECT_EQ(GetStatus().commands(), 5U);
  EXPECT_EQ(slave_.commands().size(), 1U);
}

TEST_F(OperateTest, AnEmergencyStopIsReportedAndStaysUntilReset) {
  ada.Hold(0);
  // Events are discarded while nobody reads states.
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 1; }));
  const auto stub = Connect();
  {
    grpc::ClientContext context;
    v1::StopRequest request;
    request.set_reason(std::string(300, 'r'));
    v1::Status reply;
    ASSERT_TRUE(stub->Stop(&context, request, &reply).ok());
    EXPECT_EQ(reply.phase(), v1::PHASE_ESTOP);
    EXPECT_EQ(slave_.stop_reason(), std::string(200, 'r'));
  }
  EXPECT_TRUE(ada.ReadUntil([](const auto& s) { return HasEvent(s, v1::EVENT_ESTOP); }));
  ada.Hold(-1e-3);
  const auto latched = ada.ReadUntil([](const auto& s) { return s.command_sequence() == 2; });
  ASSERT_TRUE(latched.has_value());
  EXPECT_EQ(latched->phase(), v1::PHASE_ESTOP);
  EXPECT_EQ(latched->p_s_tip().y(), FakeSlave::kHome);
  {
    grpc::ClientContext context;
    v1::Status reply;
    ASSERT_TRUE(ada.stub().ReinitializeTracking(&context, {}, &reply).ok());
    EXPECT_EQ(slave_.reinitialized(), 1);
    EXPECT_EQ(reply.phase(), v1::PHASE_ESTOP) << "cameras that start again clear no stop";
  }
  {
    grpc::ClientContext context;
    v1::Status reply;
    ASSERT_TRUE(ada.stub().Reset(&context, {}, &reply).ok());
    EXPECT_EQ(reply.phase(), v1::PHASE_READY);
  }
}

TEST_F(OperateTest, TheOperatorStopsByACommandWhateverElseItSays) {
  ada.Hold(0, "Ada");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_FOLLOWING; }));
  v1::OperatorCommand broken;  // no sequence, no place
  broken.mutable_p_m()->set_x(std::numeric_limits<double>::quiet_NaN());
  broken.set_stop(true);
  ada.Send(broken);
  EXPECT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_ESTOP; }));
  EXPECT_THAT(slave_.stop_reason(), HasSubstr("by the operator, Ada (ipv4:127.0.0.1:"));
}

TEST_F(OperateTest, AnOperatorWhoNeverReadsDoesNotKeepTheServerFromStopping) {
  ada.Hold(0);
  ASSERT_TRUE(Eventually([&] { return slave_.commands().size() == 1; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  server_->Stop();
  EXPECT_EQ(slave_.ends(), 1);
  ada.Vanish();
}

}  // namespace
}  // namespace palpate
