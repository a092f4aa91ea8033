#include "shared/wire/state_message.h"

#include <algorithm>
#include <cmath>

#include "shared/wire/fields.h"
#include "shared/wire/message_fields.h"

namespace palpate {
namespace {

constexpr int kStiffnessEntries = 9;

bool IsSendable(const LocalModel& model) {
  return model.known() && model.reference.allFinite() && model.normal.allFinite() &&
         model.force.allFinite() && model.stiffness.allFinite() && model.valid_radius > 0;
}

void WriteModel(const LocalModel& model, v1::LocalModel* message) {
  message->set_kind(v1::LocalModel::KIND_UNILATERAL_PLANE);
  ToProto(model.reference, message->mutable_reference());
  ToProto(model.normal, message->mutable_normal());
  if (!model.force.isZero(0)) ToProto(model.force, message->mutable_force());
  message->mutable_stiffness()->Reserve(kStiffnessEntries);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      message->add_stiffness(Narrow(model.stiffness(row, column)));
    }
  }
  message->set_valid_radius(Narrow(model.valid_radius));
  message->set_revision(model.revision);
  message->set_in_contact(model.in_contact);
}

LocalModel ReadModel(const v1::LocalModel& message, FieldReader* reader) {
  LocalModel model;
  if (message.kind() != v1::LocalModel::KIND_UNILATERAL_PLANE)
    return model;  // an unknown force law
  reader->Require(message.revision() > 0, "local_model.revision = 0", "1 or more");
  reader->Require(message.has_reference(), "local_model.reference is absent", "a point");
  reader->Require(message.stiffness_size() == kStiffnessEntries, "local_model.stiffness",
                  "nine numbers");
  if (!reader->ok()) return model;
  model.reference = reader->Vector("local_model.reference", message.reference(), kMaxLength);
  model.normal = reader->Vector("local_model.normal", message.normal(), 1 + kUnitTolerance);
  reader->Require(std::abs(model.normal.norm() - 1) <= kUnitTolerance, "local_model.normal",
                  "a unit vector");
  model.normal.normalize();
  model.force = reader->Vector("local_model.force", message.force(), kMaxForce);
  for (int i = 0; i < kStiffnessEntries; ++i) {
    model.stiffness(i / 3, i % 3) =
        reader->Number("local_model.stiffness", message.stiffness(i), kMaxStiffness);
  }
  model.valid_radius =
      reader->NonNegative("local_model.valid_radius", message.valid_radius(), kMaxLength);
  reader->Require(model.valid_radius > 0, "local_model.valid_radius = 0", "a length above 0");
  model.revision = message.revision();
  model.in_contact = message.in_contact();
  return model;
}

void WriteFinger(const FingerState& finger, v1::FingerContact* message) {
  if (finger.p_S_contact.allFinite()) {
    ToProto(Eigen::Vector3d(finger.p_S_contact.cast<double>()), message->mutable_p_s_contact());
  }
  const bool sendable = !finger.force || finger.force->allFinite();
  if (finger.force && sendable) {
    ToProto(Eigen::Vector3d(finger.force->cast<double>()), message->mutable_force());
  }
  message->set_in_contact(finger.in_contact);
  message->set_validity(sendable ? ToProto(finger.validity) : v1::VALIDITY_FAILED);
}

FingerState ReadFinger(const v1::FingerContact& message, FieldReader* reader) {
  FingerState finger;
  finger.p_S_contact =
      reader->Vector("fingers.p_S_contact", message.p_s_contact(), kMaxLength).cast<float>();
  finger.validity = FromProto(message.validity());
  if (message.has_force()) {
    finger.force = reader->Vector("fingers.force", message.force(), kMaxForce).cast<float>();
  }
  reader->Require(message.has_force() || !IsForceKnown(finger.validity), "fingers.force is absent",
                  "a force, or a validity that says it is unknown");
  finger.in_contact = message.in_contact();
  return finger;
}

void ReadFingers(const v1::SlaveState& message, FieldReader* reader, SlaveState* state) {
  state->finger_count = std::min(message.fingers_size(), kMaxFingers);
  for (int i = 0; i < state->finger_count; ++i) {
    state->fingers[static_cast<std::size_t>(i)] = ReadFinger(message.fingers(i), reader);
  }
}

// Lists the fields of an estimate, a state and a command with value and largest accepted magnitude,
// for writing (const states) and for reading. Parts with special rules follow below.
template <class Estimate, class Fields>
void VisitEstimate(Estimate& estimate, const Fields& field) {
  using M = v1::SlaveState;
  field(M::kSensedAtFieldNumber, estimate.sensed_at, Presence::kRequired);
  field(M::kPSTipFieldNumber, estimate.p_S_tip, kMaxLength, Presence::kRequired);
  field(M::kForceFieldNumber, estimate.force, kMaxForce);
  field(M::kSigmaFieldNumber, estimate.sigma, kMaxForce);
  field(M::kValidityFieldNumber, estimate.validity);
  field(M::kCheckFieldNumber, estimate.check);
  field(M::kMomentFieldNumber, estimate.moment, kMaxMoment);
  field(M::kMomentSigmaFieldNumber, estimate.moment_sigma, kMaxMoment);
  field(M::kEventsFieldNumber, estimate.events);
}

template <class State, class Fields>
void VisitState(State& state, const Fields& field) {
  using M = v1::SlaveState;
  field(M::kSequenceFieldNumber, state.sequence);
  field(M::kSentAtFieldNumber, state.sent_at, Presence::kRequired);
  VisitEstimate(state, field);
  field(M::kTrueForceFieldNumber, state.true_force, kMaxForce);
  field(M::kCommandSequenceFieldNumber, state.command_sequence);
  field(M::kEchoFieldNumber, state.echo);
  field(M::kEchoDelayFieldNumber, state.echo_delay, kMaxDelay);
  field(M::kEpochFieldNumber, state.epoch);
  field(M::kOffsetFieldNumber, state.offset, kMaxLength);
  field(M::kPhaseFieldNumber, state.phase);
  field(M::kSettingsRevisionFieldNumber, state.settings_revision);
  field(M::kStopsFieldNumber, state.stops);
}

template <class Command, class Fields>
void VisitCommand(Command& command, const Fields& field) {
  using M = v1::OperatorCommand;
  field(M::kSequenceFieldNumber, command.sequence);
  field(M::kSentAtFieldNumber, command.sent_at, Presence::kWritten);
  field(M::kEpochFieldNumber, command.epoch);
  field(M::kPMFieldNumber, command.p_M, kMaxLength, Presence::kWritten);
  field(M::kVelocityFieldNumber, command.velocity, kMaxSpeed);
  field(M::kEngagedFieldNumber, command.engaged);
  field(M::kStateSequenceFieldNumber, command.state_sequence);
  field(M::kEchoFieldNumber, command.echo);
  field(M::kSettingsRevisionFieldNumber, command.settings_revision);
  field(M::kStopFieldNumber, command.stop);
  field(M::kOrientationFieldNumber, command.R_M_device);
  field(M::kTorqueFieldNumber, command.torque);
}

// Writes the parts of an estimate with special rules. NaN is not sent, see the header.
void WriteParts(const ContactEstimate& estimate, v1::SlaveState* message) {
  const bool is_sendable = !estimate.force || estimate.force->allFinite();
  if (!is_sendable) {
    message->set_validity(v1::VALIDITY_FAILED);
    message->clear_moment();
  }
  if (!std::isfinite(estimate.moment_sigma)) message->clear_moment();
  if (!message->has_moment()) message->clear_moment_sigma();
  if (IsSendable(estimate.local_model)) {
    WriteModel(estimate.local_model, message->mutable_local_model());
  }
  if (estimate.finger_count < 2) return;
  for (int i = 0; i < std::min(estimate.finger_count, kMaxFingers); ++i) {
    WriteFinger(estimate.fingers[static_cast<std::size_t>(i)], message->add_fingers());
  }
}

}  // namespace

void ToProto(const ContactEstimate& estimate, v1::SlaveState* message) {
  message->Clear();
  VisitEstimate(estimate, MessageWriter(message));
  WriteParts(estimate, message);
}

void ToProto(const SlaveState& state, v1::SlaveState* message) {
  message->Clear();
  VisitState(state, MessageWriter(message));
  WriteParts(state, message);
}

std::optional<SlaveState> FromProto(const v1::SlaveState& message, std::string* reason) {
  FieldReader reader(reason);
  SlaveState state;
  VisitState(state, MessageReader(message, &reader));
  reader.Require(message.has_force() || !IsForceKnown(state.validity), "force is absent",
                 "a force, or a validity that says it is unknown");
  if (!state.moment) state.moment_sigma = 0;
  if (message.has_local_model()) state.local_model = ReadModel(message.local_model(), &reader);
  ReadFingers(message, &reader, &state);
  if (!reader.ok()) return std::nullopt;
  return state;
}

void ToProto(const CheckDetails& details, v1::CheckDetails* message) {
  message->Clear();
  const auto send = [&](const std::optional<double>& value, void (v1::CheckDetails::*set)(float)) {
    if (value && std::isfinite(*value)) (message->*set)(Narrow(*value));
  };
  send(details.score, &v1::CheckDetails::set_score);
  send(details.registration, &v1::CheckDetails::set_registration_px);
  send(details.contour, &v1::CheckDetails::set_contour_px);
  send(details.epipolar, &v1::CheckDetails::set_epipolar_px);
  send(details.camera_motion, &v1::CheckDetails::set_camera_motion_px);
  send(details.misfit, &v1::CheckDetails::set_misfit);
  send(details.rest_drift, &v1::CheckDetails::set_rest_drift);
}

void ToProto(const OperatorCommand& command, v1::OperatorCommand* message) {
  message->Clear();
  VisitCommand(command, MessageWriter(message));
}

std::optional<OperatorCommand> FromProto(const v1::OperatorCommand& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.sequence() > 0, "sequence = 0", "1 or more, rising");
  reader.Require(message.has_p_m() || !message.engaged(), "p_M is absent",
                 "a position while engaged is true");
  reader.Require(message.epoch() > 0 || !message.engaged(), "epoch = 0",
                 "1 or more while engaged is true");
  OperatorCommand command;
  VisitCommand(command, MessageReader(message, &reader));
  if (!reader.ok()) return std::nullopt;
  return command;
}

void ToProto(const SampleTrace& trace, v1::SampleTrace* message) {
  message->Clear();
  message->set_sample(trace.sample);
  ToProto(trace.sensed_at, message->mutable_sensed_at());
  const auto since = [&trace](Time at) {
    return at < trace.sensed_at ? 0 : Narrow(SecondsBetween(trace.sensed_at, at));
  };
  message->set_acquired(since(trace.acquired_at));
  message->set_processed(std::max(message->acquired(), since(trace.processed_at)));
  message->set_solved(std::max(message->processed(), since(trace.solved_at)));
}

std::optional<SampleTrace> FromProto(const v1::SampleTrace& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  if (!reader.ok()) return std::nullopt;
  SampleTrace trace;
  trace.sample = message.sample();
  trace.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  const auto at = [&](const char* name, float value) {
    return trace.sensed_at + Seconds(reader.NonNegative(name, value, kMaxDelay));
  };
  trace.acquired_at = at("acquired", message.acquired());
  trace.processed_at = at("processed", message.processed());
  trace.solved_at = at("solved", message.solved());
  if (!reader.ok()) return std::nullopt;
  return trace;
}

}  // namespace palpate
