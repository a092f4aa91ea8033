#include "tests/master/haptics/virtual_slave.h"

#include <algorithm>

namespace palpate {

void VirtualSlave::Step(Time now, LatestValue<OperatorCommand>* commands,
                        LatestValue<ReceivedState>* states) {
  if (const OperatorCommand* command = commands->Take(); command != nullptr && !IsLost()) {
    commands_.push_back({Arrival(now), *command});
  }
  for (const auto& late : commands_) {
    if (late.arrives <= now && late.message.sequence > command_sequence_) Follow(late.message);
  }
  std::erase_if(commands_, [now](const auto& late) { return late.arrives <= now; });
  if (SecondsBetween(sensed_at_, now) >= 1 / options_.sensor_rate) Sense(now);
  if (!silent && SecondsBetween(sent_at_, now) >= 1 / options_.state_rate) {
    sent_at_ = now;
    ++state_sequence_;
    if (!IsLost()) states_.push_back({Arrival(now), Compose(now)});
  }
  for (const auto& late : states_) {
    if (late.arrives > now || late.message.sequence <= delivered_) continue;
    delivered_ = late.message.sequence;
    states->Put({late.message, now, options_.clock_offset});
  }
  std::erase_if(states_, [now](const auto& late) { return late.arrives <= now; });
}

void VirtualSlave::set_K(double K) {
  options_.K = K;
  ++revision_;
}

Eigen::Vector3d VirtualSlave::ForceAt(const Eigen::Vector3d& p) const {
  return {0, std::max(0.0, options_.K * (options_.surface - p.y())), 0};
}

void VirtualSlave::Follow(const OperatorCommand& command) {
  command_sequence_ = command.sequence;
  if (command.epoch != epoch_) {
    epoch_ = command.epoch;
    mapping_ = options_.transform;
    mapping_.ZeroOffset(command.p_M, tip_);
  }
  engaged_ = command.engaged;
  if (engaged_) tip_ = mapping_.ToSlave(command.p_M);
}

void VirtualSlave::Sense(Time now) {
  sensed_at_ = now;
  sensed_tip_ = tip_;
  sensed_force_ = ForceAt(tip_);
}

SlaveState VirtualSlave::Compose(Time now) const {
  SlaveState state;
  state.sequence = state_sequence_;
  state.sensed_at = sensed_at_ + Seconds(options_.clock_offset);
  state.sent_at = now + Seconds(options_.clock_offset);
  state.p_S_tip = sensed_tip_;
  state.force = sensed_force_;
  state.validity = validity;
  state.local_model.reference = {0, options_.surface, 0};
  state.local_model.stiffness(1, 1) = options_.K;
  state.local_model.valid_radius = 0.05;
  state.local_model.revision = revision_;
  state.local_model.in_contact = sensed_force_.y() > 0;
  state.epoch = forgets ? 0 : epoch_;
  state.offset = mapping_.offset;
  state.phase = engaged_ ? Phase::kFollowing : Phase::kClutched;
  if (forced_phase == Phase::kEstop) state.phase = forced_phase;
  state.true_force = ForceAt(tip_);
  return state;
}

}  // namespace palpate
