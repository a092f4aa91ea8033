#include "shared/wire/state_message.h"

#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/shared/wire/samples.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

v1::SlaveState FullMessage() {
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

// Reference: the state that was sent; every number of the sample is exact on the wire.
TEST(StateMessageTest, WhatWasSentIsWhatArrives) {
  const SlaveState sent = FullState();
  v1::SlaveState over_the_wire;
  ASSERT_TRUE(over_the_wire.ParseFromString(FullMessage().SerializeAsString()));
  const SlaveState got = Read(over_the_wire);
  EXPECT_EQ(got.sequence, sent.sequence);
  EXPECT_EQ(got.sensed_at, sent.sensed_at);
  EXPECT_EQ(got.sent_at, sent.sent_at);
  EXPECT_EQ(got.p_S_tip, sent.p_S_tip);
  EXPECT_EQ(got.force, sent.force);
  EXPECT_EQ(got.sigma, sent.sigma);
  EXPECT_EQ(got.validity, sent.validity);
  EXPECT_EQ(got.check, sent.check);
  EXPECT_EQ(got.local_model.reference, sent.local_model.reference);
  EXPECT_EQ(got.local_model.normal, sent.local_model.normal);
  EXPECT_EQ(got.local_model.force, sent.local_model.force);
  EXPECT_EQ(got.local_model.stiffness, sent.local_model.stiffness);
  EXPECT_EQ(got.local_model.valid_radius, sent.local_model.valid_radius);
  EXPECT_EQ(got.local_model.revision, sent.local_model.revision);
  EXPECT_EQ(got.local_model.in_contact, sent.local_model.in_contact);
  EXPECT_EQ(got.energy_in, sent.energy_in);
  EXPECT_EQ(got.energy_out, sent.energy_out);
  EXPECT_TRUE(got.events.Has(Event::kContact));
  EXPECT_TRUE(got.events.Has(Event::kCommandRefused));
  EXPECT_FALSE(got.events.Has(Event::kRelease));
  EXPECT_EQ(got.command_sequence, sent.command_sequence);
  EXPECT_EQ(got.echo, sent.echo);
  EXPECT_EQ(got.echo_delay, sent.echo_delay);
  EXPECT_EQ(got.epoch, sent.epoch);
  EXPECT_EQ(got.offset, sent.offset);
  EXPECT_EQ(got.phase, sent.phase);
  EXPECT_EQ(got.true_force, sent.true_force);
  EXPECT_EQ(got.moment, sent.moment);
  EXPECT_EQ(got.moment_sigma, sent.moment_sigma);
  ASSERT_EQ(got.finger_count, sent.finger_count);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(got.fingers[i].p_S_contact, sent.fingers[i].p_S_contact);
    EXPECT_EQ(got.fingers[i].force, sent.fingers[i].force);
    EXPECT_EQ(got.fingers[i].in_contact, sent.fingers[i].in_contact);
    EXPECT_EQ(got.fingers[i].validity, sent.fingers[i].validity);
  }
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

TEST(StateMessageTest, WhatIsNotFiniteAtAFingerIsSentAsUnknown) {
  SlaveState state = FullState();
  state.fingers[0].force = Eigen::Vector3f(1, NAN, 0);
  state.fingers[1].p_S_contact.x() = INFINITY;
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_FALSE(message.fingers(0).has_force());
  EXPECT_EQ(message.fingers(0).validity(), v1::VALIDITY_FAILED);
  EXPECT_FALSE(message.fingers(1).has_p_s_contact());
  EXPECT_FALSE(Read(message).fingers[0].force.has_value());
}

TEST(StateMessageTest, OfMoreFingersThanAHandHasTheFirstAreRead) {
  v1::SlaveState message = FullMessage();
  while (message.fingers_size() < 9) *message.add_fingers() = message.fingers(0);
  EXPECT_EQ(Read(message).finger_count, kMaxFingers);
}

TEST(StateMessageTest, AStiffnessMatrixTravelsRowByRow) {
  EXPECT_THAT(FullMessage().local_model().stiffness(),
              testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
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

TEST(StateMessageTest, ANotFiniteForceIsSentAsUnknown) {
  SlaveState state = FullState();
  state.force = Eigen::Vector3d(1, kNan, 0);
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_FALSE(message.has_force());
  EXPECT_EQ(message.validity(), v1::VALIDITY_FAILED);
}

TEST(StateMessageTest, ANotFiniteLocalModelIsSentAsNone) {
  SlaveState state = FullState();
  state.local_model.stiffness(1, 1) = kInf;
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_FALSE(message.has_local_model());
  EXPECT_FALSE(Read(message).local_model.known());
}

TEST(StateMessageTest, ANotFiniteMomentIsSentAsUnknown) {
  SlaveState state = FullState();
  state.moment->y() = kNan;
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_FALSE(message.has_moment());
  state = FullState();
  state.moment_sigma = kInf;
  ToProto(state, &message);
  EXPECT_FALSE(message.has_moment());
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
  return state;
}

// Reference: contracts, at most 256 bytes for one contact.
TEST(StateMessageTest, TheLargestPlanarStateFitsInto256Bytes) {
  SlaveState state = LargestPlanarState();
  state.moment.reset();
  v1::SlaveState message;
  ToProto(state, &message);
  EXPECT_LE(message.ByteSizeLong(), kMaxStateBytes);
  EXPECT_GE(message.ByteSizeLong(), kMaxStateBytes - 16) << "the test no longer looks at the worst";
}

TEST(StateMessageTest, WhatANewerSlaveMayHaveAddedIsReadWithCare) {
  v1::SlaveState message = FullMessage();
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

struct Malformation {
  const char* reason;  // what the refusal must name
  std::function<void(v1::SlaveState*)> apply;
};

class MalformedStateTest : public testing::TestWithParam<Malformation> {};

TEST_P(MalformedStateTest, IsRefusedAndNamed) {
  v1::SlaveState message = FullMessage();
  GetParam().apply(&message);
  std::string reason;
  EXPECT_FALSE(FromProto(message, &reason).has_value());
  EXPECT_THAT(reason, testing::HasSubstr(GetParam().reason));
  EXPECT_THAT(reason, testing::HasSubstr("expected"));
}

INSTANTIATE_TEST_SUITE_P(
    OneFieldEach, MalformedStateTest,
    testing::Values(
        Malformation{"sensed_at is absent", [](auto* m) { m->clear_sensed_at(); }},
        Malformation{"sent_at", [](auto* m) { m->mutable_sent_at()->set_nanos(1'000'000'000); }},
        Malformation{"p_S_tip is absent", [](auto* m) { m->clear_p_s_tip(); }},
        Malformation{"p_S_tip.y = nan", [](auto* m) { m->mutable_p_s_tip()->set_y(kNan); }},
        Malformation{"force is absent", [](auto* m) { m->clear_force(); }},
        Malformation{"force.z = -inf", [](auto* m) { m->mutable_force()->set_z(-kInf); }},
        Malformation{"sigma", [](auto* m) { m->set_sigma(-1); }},
        Malformation{"energy_in", [](auto* m) { m->set_energy_in(-0.5F); }},
        Malformation{"echo_delay", [](auto* m) { m->set_echo_delay(-1e-3F); }},
        Malformation{"moment.y", [](auto* m) { m->mutable_moment()->set_y(NAN); }},
        Malformation{"moment_sigma", [](auto* m) { m->set_moment_sigma(-1); }},
        Malformation{"fingers.force is absent",
                     [](auto* m) { m->mutable_fingers(0)->clear_force(); }},
        Malformation{"fingers.p_S_contact.z",
                     [](auto* m) { m->mutable_fingers(1)->mutable_p_s_contact()->set_z(1e9F); }},
        Malformation{"local_model.stiffness",
                     [](auto* m) { m->mutable_local_model()->mutable_stiffness()->RemoveLast(); }},
        Malformation{"local_model.normal",
                     [](auto* m) { m->mutable_local_model()->clear_normal(); }},
        Malformation{"local_model.reference",
                     [](auto* m) { m->mutable_local_model()->clear_reference(); }},
        Malformation{"local_model.valid_radius",
                     [](auto* m) { m->mutable_local_model()->set_valid_radius(INFINITY); }}));

}  // namespace
}  // namespace palpate
