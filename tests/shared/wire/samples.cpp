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
  state.events.Add(Event::kContact);
  state.events.Add(Event::kCommandRefused);
  state.command_sequence = 99;
  state.echo = At(1'600'000'000, 5);
  state.echo_delay = 0.001953125;
  state.epoch = 3;
  state.offset = {0.5, 0.25, -0.125};
  state.phase = Phase::kFollowing;
  state.settings_revision = 5;
  state.stops = 1'700'000'000'123;
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
  command.state_sequence = 40;
  command.echo = At(1'700'000'000, 999'999'999);
  command.settings_revision = 5;
  command.stop = true;
  command.R_M_device = Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5);
  command.torque = true;
  return command;
}

const char* const kFullStateText = R"(
  sequence: 41
  sensed_at { seconds: 1700000000 nanos: 1 }
  sent_at { seconds: 1700000000 nanos: 999999999 }
  p_S_tip { x: 0.1 y: -0.2 z: 0.3 }
  force { x: -1.1 y: 2.2 z: 3.3 }
  sigma: 0.125
  validity: VALIDITY_EXTRAPOLATED
  check: FAILED_CHECK_INDENTATION
  local_model {
    kind: KIND_UNILATERAL_PLANE
    reference { x: 0.25 y: -0.5 z: 0.75 }
    normal { z: -1 }
    force { x: 0.5 y: 1.5 z: -2.5 }
    stiffness: [ 1, 2, 3, 4, 5, 6, 7, 8, 9 ]  # row by row
    valid_radius: 0.0625
    revision: 7
    in_contact: true
  }
  events: [ EVENT_CONTACT, EVENT_COMMAND_REFUSED ]
  command_sequence: 99
  echo { seconds: 1600000000 nanos: 5 }
  echo_delay: 0.001953125
  epoch: 3
  offset { x: 0.5 y: 0.25 z: -0.125 }
  phase: PHASE_FOLLOWING
  settings_revision: 5
  stops: 1700000000123
  true_force { x: -1 y: 2 z: 3 }
  moment { x: 0.5 y: -0.25 z: 2 }
  moment_sigma: 0.0625
  fingers {
    p_S_contact { x: 0.5 y: -0.25 z: 0.125 }
    force { x: 1 y: -2 z: 4 }
    in_contact: true
    validity: VALIDITY_VALID
  }
  fingers {
    p_S_contact { x: 0.25 y: 0.5 z: -2 }
    in_contact: true
    validity: VALIDITY_TRACKING_LOST
  }
)";

const char* const kFullCommandText = R"(
  sequence: 12
  sent_at { seconds: 1700000001 nanos: 250 }
  epoch: 2
  p_M { x: 0.01 y: -0.02 z: 0.03 }
  velocity { x: 1 y: 2 z: -3 }
  engaged: true
  state_sequence: 40
  echo { seconds: 1700000000 nanos: 999999999 }
  settings_revision: 5
  stop: true
  orientation: [ 0.5, -0.5, 0.5, 0.5 ]
  torque: true
)";

}  // namespace palpate
