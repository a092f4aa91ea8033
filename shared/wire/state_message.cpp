#include "shared/wire/state_message.h"

#include <algorithm>
#include <cmath>

#include "shared/wire/fields.h"

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
    return model;  // a law not known here
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

void ReadEcho(const v1::SlaveState& message, FieldReader* reader, SlaveState* state) {
  state->command_sequence = message.command_sequence();
  if (message.has_echo()) state->echo = reader->Stamp("echo", message.echo());
  state->echo_delay = reader->NonNegative("echo_delay", message.echo_delay(), kMaxDelay);
}

void ReadForces(const v1::SlaveState& message, FieldReader* reader, SlaveState* state) {
  state->validity = FromProto(message.validity());
  state->check = FromProto(message.check());
  if (message.has_force()) state->force = reader->Vector("force", message.force(), kMaxForce);
  reader->Require(message.has_force() || !IsForceKnown(state->validity), "force is absent",
                  "a force, or a validity that says it is unknown");
  state->sigma = reader->NonNegative("sigma", message.sigma(), kMaxForce);
  if (message.has_true_force()) {
    state->true_force = reader->Vector("true_force", message.true_force(), kMaxForce);
  }
  if (message.has_moment()) {
    state->moment = reader->Vector("moment", message.moment(), kMaxMoment);
    state->moment_sigma = reader->NonNegative("moment_sigma", message.moment_sigma(), kMaxMoment);
  }
  if (message.has_local_model()) state->local_model = ReadModel(message.local_model(), reader);
}

}  // namespace

void ToProto(const SlaveState& state, v1::SlaveState* message) {
  message->Clear();
  message->set_sequence(state.sequence);
  ToProto(state.sensed_at, message->mutable_sensed_at());
  ToProto(state.sent_at, message->mutable_sent_at());
  ToProto(state.p_S_tip, message->mutable_p_s_tip());
  const bool sendable = !state.force || state.force->allFinite();
  if (state.force && sendable) ToProto(*state.force, message->mutable_force());
  message->set_validity(sendable ? ToProto(state.validity) : v1::VALIDITY_FAILED);
  message->set_check(ToProto(state.check));
  message->set_sigma(std::isfinite(state.sigma) ? Narrow(state.sigma) : 0);
  if (IsSendable(state.local_model)) WriteModel(state.local_model, message->mutable_local_model());
  message->set_energy_in(Narrow(state.energy_in));
  message->set_energy_out(Narrow(state.energy_out));
  ToProto(state.events, message->mutable_events());
  message->set_command_sequence(state.command_sequence);
  if (state.echo && *state.echo != Time{}) ToProto(*state.echo, message->mutable_echo());
  message->set_echo_delay(Narrow(state.echo_delay));
  message->set_epoch(state.epoch);
  if (!state.offset.isZero(0)) ToProto(state.offset, message->mutable_offset());
  message->set_phase(ToProto(state.phase));
  message->set_settings_revision(state.settings_revision);
  if (state.true_force) ToProto(*state.true_force, message->mutable_true_force());
  if (state.finger_count < 2) return;
  for (int i = 0; i < std::min(state.finger_count, kMaxFingers); ++i) {
    WriteFinger(state.fingers[static_cast<std::size_t>(i)], message->add_fingers());
  }
}

std::optional<SlaveState> FromProto(const v1::SlaveState& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  reader.Require(message.has_sent_at(), "sent_at is absent", "a time");
  reader.Require(message.has_p_s_tip(), "p_S_tip is absent", "a point");
  if (!reader.ok()) return std::nullopt;
  SlaveState state;
  state.sequence = message.sequence();
  state.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  state.sent_at = reader.Stamp("sent_at", message.sent_at());
  state.p_S_tip = reader.Vector("p_S_tip", message.p_s_tip(), kMaxLength);
  ReadForces(message, &reader, &state);
  state.energy_in = reader.NonNegative("energy_in", message.energy_in(), kMaxEnergy);
  state.energy_out = reader.NonNegative("energy_out", message.energy_out(), kMaxEnergy);
  state.events = FromProto(message.events());
  ReadEcho(message, &reader, &state);
  state.epoch = message.epoch();
  state.offset = reader.Vector("offset", message.offset(), kMaxLength);
  state.phase = FromProto(message.phase());
  state.settings_revision = message.settings_revision();
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
  message->set_sequence(command.sequence);
  ToProto(command.sent_at, message->mutable_sent_at());
  message->set_epoch(command.epoch);
  ToProto(command.p_M, message->mutable_p_m());
  ToProto(command.velocity, message->mutable_velocity());
  message->set_engaged(command.engaged);
  message->set_energy_in(command.energy_in);
  message->set_energy_out(command.energy_out);
  message->set_state_sequence(command.state_sequence);
  if (command.echo) ToProto(*command.echo, message->mutable_echo());
  message->set_settings_revision(command.settings_revision);
  message->set_stop(command.stop);
  ToProto(command.R_M_device, message->mutable_orientation());
  message->set_torque(command.torque);
}

std::optional<OperatorCommand> FromProto(const v1::OperatorCommand& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.sequence() > 0, "sequence = 0", "1 or more, rising");
  reader.Require(message.has_p_m() || !message.engaged(), "p_M is absent",
                 "a position while engaged is true");
  reader.Require(message.epoch() > 0 || !message.engaged(), "epoch = 0",
                 "1 or more while engaged is true");
  OperatorCommand command;
  command.sequence = message.sequence();
  if (message.has_sent_at()) command.sent_at = reader.Stamp("sent_at", message.sent_at());
  command.epoch = message.epoch();
  command.p_M = reader.Vector("p_M", message.p_m(), kMaxLength);
  command.velocity = reader.Vector("velocity", message.velocity(), kMaxSpeed);
  command.engaged = message.engaged();
  command.energy_in = reader.NonNegative("energy_in", message.energy_in(), kMaxEnergy);
  command.energy_out = reader.NonNegative("energy_out", message.energy_out(), kMaxEnergy);
  command.state_sequence = message.state_sequence();
  if (message.has_echo()) command.echo = reader.Stamp("echo", message.echo());
  command.settings_revision = message.settings_revision();
  command.stop = message.stop();
  command.R_M_device = reader.Rotation("orientation", message.orientation());
  command.torque = message.torque();
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
