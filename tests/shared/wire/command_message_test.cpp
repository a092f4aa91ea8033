#include <functional>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/wire/state_message.h"
#include "tests/shared/wire/samples.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

v1::OperatorCommand FullMessage() {
  v1::OperatorCommand message;
  ToProto(FullCommand(), &message);
  return message;
}

// Reference: the command that was sent; it travels in double precision, so bit for bit.
TEST(CommandMessageTest, WhatWasSentIsWhatArrives) {
  const OperatorCommand sent = FullCommand();
  v1::OperatorCommand over_the_wire;
  ASSERT_TRUE(over_the_wire.ParseFromString(FullMessage().SerializeAsString()));
  std::string reason;
  const auto got = FromProto(over_the_wire, &reason);
  ASSERT_TRUE(got.has_value()) << reason;
  EXPECT_EQ(got->sequence, sent.sequence);
  EXPECT_EQ(got->sent_at, sent.sent_at);
  EXPECT_EQ(got->epoch, sent.epoch);
  EXPECT_EQ(got->p_M, sent.p_M);
  EXPECT_EQ(got->velocity, sent.velocity);
  EXPECT_EQ(got->engaged, sent.engaged);
  EXPECT_EQ(got->energy_in, sent.energy_in);
  EXPECT_EQ(got->energy_out, sent.energy_out);
  EXPECT_EQ(got->state_sequence, sent.state_sequence);
  EXPECT_EQ(got->echo, sent.echo);
  ASSERT_TRUE(got->R_M_device.has_value());
  EXPECT_EQ(got->R_M_device->coeffs(), sent.R_M_device->coeffs());
  EXPECT_EQ(got->torque, sent.torque);
}

void SetRotation(const std::vector<double>& numbers, v1::OperatorCommand* message) {
  message->mutable_orientation()->Assign(numbers.begin(), numbers.end());
}

TEST(CommandMessageTest, ARotationRoundedToSinglePrecisionIsMadeAUnitQuaternion) {
  v1::OperatorCommand message = FullMessage();
  SetRotation({0.6005, 0, -0.8005, 0}, &message);
  std::string reason;
  const auto command = FromProto(message, &reason);
  ASSERT_TRUE(command.has_value()) << reason;
  EXPECT_NEAR(command->R_M_device->norm(), 1, 1e-15);
  EXPECT_NEAR(command->R_M_device->w(), 0.6, 1e-3);
}

TEST(CommandMessageTest, ACommandThatEngagesNothingNeedsNoPlaceAndNoStamp) {
  v1::OperatorCommand message;
  message.set_sequence(1);
  message.set_operator_name("first word");
  std::string reason;
  const auto command = FromProto(message, &reason);
  ASSERT_TRUE(command.has_value()) << reason;
  EXPECT_EQ(command->sent_at, Time{});
  EXPECT_FALSE(command->engaged);
}

struct Malformation {
  const char* reason;
  std::function<void(v1::OperatorCommand*)> apply;
};

class MalformedCommandTest : public testing::TestWithParam<Malformation> {};

TEST_P(MalformedCommandTest, IsRefusedAndNamed) {
  v1::OperatorCommand message = FullMessage();
  GetParam().apply(&message);
  std::string reason;
  EXPECT_FALSE(FromProto(message, &reason).has_value());
  EXPECT_THAT(reason, testing::HasSubstr(GetParam().reason));
  EXPECT_THAT(reason, testing::HasSubstr("expected"));
}

INSTANTIATE_TEST_SUITE_P(
    OneFieldEach, MalformedCommandTest,
    testing::Values(Malformation{"sequence = 0", [](auto* m) { m->clear_sequence(); }},
                    Malformation{"epoch = 0", [](auto* m) { m->clear_epoch(); }},
                    Malformation{"p_M is absent", [](auto* m) { m->clear_p_m(); }},
                    Malformation{"p_M.x = nan", [](auto* m) { m->mutable_p_m()->set_x(kNan); }},
                    Malformation{"p_M.z = 1e+300", [](auto* m) { m->mutable_p_m()->set_z(1e300); }},
                    Malformation{"energy_out", [](auto* m) { m->set_energy_out(kNan); }},
                    Malformation{"sent_at", [](auto* m) { m->mutable_sent_at()->set_nanos(-1); }},
                    Malformation{"orientation",
                                 [](auto* m) {
                                   SetRotation({1, 0, 0}, m);
                                 }},
                    Malformation{"orientation",
                                 [](auto* m) {
                                   SetRotation({1e200, 1e200, 0, 0}, m);
                                 }},
                    Malformation{"orientation", [](auto* m) {
                                   SetRotation({kInf, 0, 0, 0}, m);
                                 }}));

}  // namespace
}  // namespace palpate
