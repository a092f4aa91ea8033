#include "shared/wire/state_message.h"

#include <functional>

#include <gtest/gtest.h>

#include "tests/shared/wire/samples.h"
#include "tests/support/not_finite.h"

namespace palpate {
namespace {

v1::SlaveState FullStateMessage() {
  v1::SlaveState message;
  ToProto(FullState(), &message);
  return message;
}

SlaveState Read(const v1::SlaveState& message) {
  std::string reason;
  const auto state = FromProto(message, &reason);
  EXPECT_TRUE(state.has_value()) << reason;
  return state.value_or(SlaveState{});
}

TEST(StateMessageTest, EveryFieldTravels) {
  // Other fields: details, datagrams and datagrams_seen.
  ExpectTravelsWhole<v1::SlaveState>(FullState(), kFullStateText, 3);
}

TEST(StateMessageTest, OneFingerIsTheToolAndIsNotSentTwice) {
  SlaveState state = FullState();
  state.finger_count = 1;
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_EQ(message.fingers_size(), 0);
  state.finger_count = kMaxFingers;
  ToProto(state, &message);
  EXPECT_EQ(message.fingers_size(), kMaxFingers);
}

TEST(StateMessageTest, OfTooManyFingersTheFirstAreRead) {
  v1::SlaveState message = FullStateMessage();
  while (message.fingers_size() < 9) *message.add_fingers() = message.fingers(0);
  EXPECT_EQ(Read(message).finger_count, kMaxFingers);
}

TEST(StateMessageTest, AnUnknownForceArrivesUnknownAndNotZero) {
  SlaveState state = FullState();
  state.force.reset();
  state.true_force.reset();
  state.validity = Validity::kTrackingLost;
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_FALSE(message.has_force());
  EXPECT_FALSE(Read(message).force.has_value());
  EXPECT_FALSE(Read(message).true_force.has_value());
}

// A value that is not finite is absent from the message; it is not replaced by a number.
TEST(StateMessageTest, WhatIsNotFiniteIsSentAsUnknown) {
  const auto sent = [](const std::function<void(SlaveState*)>& alter) {
    SlaveState state = FullState();
    alter(&state);
    v1::SlaveState message;
    ToProto(state, &message);
    Read(message);
    return message;
  };
  const auto force = sent([](SlaveState* s) { s->force->y() = kNan; });
  EXPECT_FALSE(force.has_force());
  EXPECT_EQ(force.validity(), v1::VALIDITY_FAILED);
  const auto finger = sent([](SlaveState* s) { s->fingers[0].force->y() = NAN; }).fingers(0);
  EXPECT_FALSE(finger.has_force());
  EXPECT_EQ(finger.validity(), v1::VALIDITY_FAILED);
  const auto place = [](SlaveState* s) { s->fingers[1].p_S_contact.x() = INFINITY; };
  EXPECT_FALSE(sent(place).fingers(1).has_p_s_contact());
  const auto model = [](SlaveState* s) { s->local_model.stiffness(1, 1) = kInf; };
  EXPECT_FALSE(sent(model).has_local_model());
  EXPECT_FALSE(sent([](SlaveState* s) { s->moment->y() = kNan; }).has_moment());
  EXPECT_FALSE(sent([](SlaveState* s) { s->moment_sigma = kInf; }).has_moment());
}

// The largest planar state: every optional field present, all ten events at once, no component zero
// within the plane, sequences of ten years at 1 kHz, revision and epoch of ten months at ten a
// second, a hundred changes of settings. The force at a linear model's reference is zero.
SlaveState LargestPlanarState() {
  SlaveState state = FullState();
  state.finger_count = 0;
  constexpr std::uint64_t kTenYears = 315'360'000'000;
  state.sequence = state.command_sequence = kTenYears;
  state.sensed_at = state.sent_at = Time(std::chrono::nanoseconds(4'102'444'799'999'999'999));
  state.echo = state.sent_at;
  for (int e = v1::EVENT_CONTACT; e <= v1::Event_MAX; ++e) state.events.Add(static_cast<Event>(e));
  state.p_S_tip = {-0.1, -0.2, 0};
  state.force = state.true_force = Eigen::Vector3d(-1.1, -2.2, 0);
  state.local_model.reference = {0.1, 0.2, 0};
  state.local_model.normal = {0.6, -0.8, 0};
  state.local_model.force.setZero();
  state.offset = {0.1, 0.2, 0};
  state.epoch = state.local_model.revision = (1U << 28) - 1;
  state.check = FailedCheck::kTransfer;
  state.settings_revision = 100;
  state.stops = 1'800'000'000'000;  // milliseconds since 1970
  return state;
}

// Reference: proto/README.md, at most 256 bytes for one contact.
TEST(StateMessageTest, TheLargestPlanarStateFitsInto256Bytes) {
  SlaveState state = LargestPlanarState();
  state.moment.reset();
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_LE(message.ByteSizeLong(), kMaxStateBytes);
  EXPECT_GE(message.ByteSizeLong(), kMaxStateBytes - 16) << "the test no longer looks at the worst";
}

TEST(StateMessageTest, UnknownEnumerationValuesBecomeSafeOnes) {
  v1::SlaveState message = FullStateMessage();
  message.set_validity(static_cast<v1::Validity>(77));
  message.set_phase(static_cast<v1::Phase>(77));
  message.add_events(static_cast<v1::Event>(77));
  message.set_check(static_cast<v1::FailedCheck>(77));
  message.mutable_local_model()->set_kind(static_cast<v1::LocalModel::Kind>(77));
  const SlaveState state = Read(message);
  EXPECT_EQ(state.validity, Validity::kFailed);
  EXPECT_EQ(state.phase, Phase::kHold);
  EXPECT_EQ(state.check, FailedCheck::kNone);
  EXPECT_TRUE(state.events.Has(Event::kContact));
  EXPECT_FALSE(state.local_model.known());
}

using StateRow = Malformation<v1::SlaveState>;
class MalformedStateTest : public testing::TestWithParam<StateRow> {};

TEST_P(MalformedStateTest, IsRefusedAndNamed) {
  ExpectRefused(FullStateMessage(), GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    OneFieldEach, MalformedStateTest,
    testing::Values(
        StateRow{"sensed_at is absent", [](auto* m) { m->clear_sensed_at(); }},
        StateRow{"sent_at", [](auto* m) { m->mutable_sent_at()->set_nanos(1'000'000'000); }},
        StateRow{"p_S_tip is absent", [](auto* m) { m->clear_p_s_tip(); }},
        StateRow{"p_S_tip.y = nan", [](auto* m) { m->mutable_p_s_tip()->set_y(kNan); }},
        StateRow{"force is absent", [](auto* m) { m->clear_force(); }},
        StateRow{"force.z = -inf", [](auto* m) { m->mutable_force()->set_z(-kInf); }},
        StateRow{"sigma", [](auto* m) { m->set_sigma(-1); }},
        StateRow{"echo_delay", [](auto* m) { m->set_echo_delay(-1e-3F); }},
        StateRow{"moment.y", [](auto* m) { m->mutable_moment()->set_y(NAN); }},
        StateRow{"moment_sigma", [](auto* m) { m->set_moment_sigma(-1); }},
        StateRow{"fingers.force is absent", [](auto* m) { m->mutable_fingers(0)->clear_force(); }},
        StateRow{"fingers.p_S_contact.z",
                 [](auto* m) { m->mutable_fingers(1)->mutable_p_s_contact()->set_z(1e9F); }},
        StateRow{"local_model.stiffness",
                 [](auto* m) { m->mutable_local_model()->mutable_stiffness()->RemoveLast(); }},
        StateRow{"local_model.normal", [](auto* m) { m->mutable_local_model()->clear_normal(); }},
        StateRow{"local_model.reference",
                 [](auto* m) { m->mutable_local_model()->clear_reference(); }},
        StateRow{"local_model.valid_radius",
                 [](auto* m) { m->mutable_local_model()->set_valid_radius(INFINITY); }}));

}  // namespace
}  // namespace palpate
