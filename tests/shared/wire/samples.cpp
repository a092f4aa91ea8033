#include "tests/shared/wire/samples.h"

namespace palpate {
namespace {

Time At(std::int64_t seconds, std::int64_t nanos) {
  return Time(std::chrono::seconds(seconds) + std::chrono::nanoseconds(nanos));
}

}  // namespace

SlaveState FullState() {
  SlaveState state;
  state.sequence = 41;
  state.sensed_at = At(1'700'000'000, 1);
  state.sent_at = At(1'700'000'000, 999'999'999);
  state.p_S_tip = {0.1, -0.2, 0.3};
  state.force = Eigen::Vector3d(-1.1, 2.2, 3.3);
  state.sigma = 0.125;
  state.validity = Validity::kExtrapolated;
  state.check = FailedCheck::kIndentation;
  state.local_model.reference = {0.25, -0.5, 0.75};
  state.local_model.normal = {0, 0, -1};
  state.local_model.force = {0.5, 1.5, -2.5};
  state.local_model.stiffness << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  state.local_model.valid_radius = 0.0625;
  state.local_model.revision = 7;
  state.local_model.in_contact = true;
  state.energy_in = 1.25;
  state.energy_out = 0.75;
  state.events.Add(Event::kContact);
  state.events.Add(Event::kCommandRefused);
  state.command_sequence = 99;
  state.echo = At(1'600'000'000, 5);
  state.echo_delay = 0.001953125;
  state.epoch = 3;
  state.offset = {0.5, 0.25, -0.125};
  state.phase = Phase::kFollowing;
  state.settings_revision = 5;
  state.true_force = Eigen::Vector3d(-1, 2, 3);
  state.moment = Eigen::Vector3d(0.5, -0.25, 2);
  state.moment_sigma = 0.0625;
  state.finger_count = 2;
  state.fingers[0] = {{0.5F, -0.25F, 0.125F}, Eigen::Vector3f(1, -2, 4), true, Validity::kValid};
  state.fingers[1] = {{0.25F, 0.5F, -2}, std::nullopt, true, Validity::kTrackingLost};
  return state;
}

OperatorCommand FullCommand() {
  OperatorCommand command;
  command.sequence = 12;
  command.sent_at = At(1'700'000'001, 250);
  command.epoch = 2;
  command.p_M = {0.01, -0.02, 0.03};
  command.velocity = {1, 2, -3};
  command.engaged = true;
  command.energy_in = 0.5;
  command.energy_out = 0.25;
  command.state_sequence = 40;
  command.echo = At(1'700'000'000, 999'999'999);
  command.settings_revision = 5;
  command.stop = true;
  command.R_M_device = Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5);
  command.torque = true;
  return command;
}

}  // namespace palpate
