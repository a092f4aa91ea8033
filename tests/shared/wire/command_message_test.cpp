#include <vector>

#include <gtest/gtest.h>

#include "shared/wire/state_message.h"
#include "tests/shared/wire/samples.h"
#include "tests/support/not_finite.h"

namespace palpate {
namespace {

v1::OperatorCommand FullCommandMessage() {
  v1::OperatorCommand message;
  ToProto(FullCommand(), &message);
  return message;
}

TEST(CommandMessageTest, EveryFieldTravels) {
  // Other fields: operator_name, datagrams, datagrams_seen and details.
  ExpectTravelsWhole<v1::OperatorCommand>(FullCommand(), kFullCommandText, 4);
}

void SetRotation(const std::vector<double>& numbers, v1::OperatorCommand* message) {
  message->mutable_orientation()->Assign(numbers.begin(), numbers.end());
}

TEST(CommandMessageTest, ARotationRoundedToSinglePrecisionIsMadeAUnitQuaternion) {
  v1::OperatorCommand message = FullCommandMessage();
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

using CommandRow = Malformation<v1::OperatorCommand>;
class MalformedCommandTest : public testing::TestWithParam<CommandRow> {};

TEST_P(MalformedCommandTest, IsRefusedAndNamed) {
  ExpectRefused(FullCommandMessage(), GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    OneFieldEach, MalformedCommandTest,
    testing::Values(CommandRow{"sequence = 0", [](auto* m) { m->clear_sequence(); }},
                    CommandRow{"epoch = 0", [](auto* m) { m->clear_epoch(); }},
                    CommandRow{"p_M is absent", [](auto* m) { m->clear_p_m(); }},
                    CommandRow{"p_M.x = nan", [](auto* m) { m->mutable_p_m()->set_x(kNan); }},
                    CommandRow{"p_M.z = 1e+300", [](auto* m) { m->mutable_p_m()->set_z(1e300); }},
                    CommandRow{"sent_at", [](auto* m) { m->mutable_sent_at()->set_nanos(-1); }},
                    CommandRow{"orientation",
                               [](auto* m) {
                                 SetRotation({1, 0, 0}, m);
                               }},
                    CommandRow{"orientation",
                               [](auto* m) {
                                 SetRotation({1e200, 1e200, 0, 0}, m);
                               }},
                    CommandRow{"orientation", [](auto* m) {
                                 SetRotation({kInf, 0, 0, 0}, m);
                               }}));

}  // namespace
}  // namespace palpate
