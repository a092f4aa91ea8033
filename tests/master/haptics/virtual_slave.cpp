#include "tests/master/haptics/virtual_slave.h"

#include <algorithm>

namespace palpate {
namespace {

template <class Line>
bool IsHere(const Line& line, Time now) {
  return !line.empty() && line.begin()->first <= now;
}

}  // namespace

void VirtualSlave::Step(Time now, LatestValue<OperatorCommand>* commands,
                        LatestValue<ReceivedState>* states) {
  if (const OperatorCommand* command = commands->Take(); command != nullptr && !IsLost()) {
    commands_.emplace(Arrival(now), *command);
  }
  for (; IsHere(commands_, now); commands_.erase(commands_.begin())) {
    const OperatorCommand& command = commands_.begin()->second;
    if (command.sequence <= command_sequence_) continue;
    Follow(command);
    taken_at_ = now;
  }
  if (SecondsBetween(sensed_at_, now) >= 1 / options_.sensor_rate) TakeSample(now);
  if (!silent && SecondsBetween(sent_at_, now) >= 1 / options_.state_rate) {
    sent_at_ = now;
    ++state_sequence_;
    SlaveState state = Compose(now);
    if (falsify) falsify(&state);
    if (!IsLost()) states_.emplace(Arrival(now), state);
  }
  for (; IsHere(states_, now); states_.erase(states_.begin())) {
    const SlaveState& state = states_.begin()->second;
    if (state.sequence <= delivered_) continue;
    delivered_ = state.sequence;
    states->Put({state, now, options_.clock_offset, 2 * (options_.delay + options_.jitter)});
  }
}

void VirtualSlave::set_K(double K) {
  options_.K = K;
  ++revision_;
}

Eigen::Vector3d VirtualSlave::ForceAt(const Eigen::Vector3d& p) const {
  const double depth = DepthOf(p);
  if (!(depth > 0)) return {0, 0, 0};
  return options_.K * depth * options_.normal + options_.shear * (entry_ - OnPlane(p));
}

void VirtualSlave::MoveTo(const Eigen::Vector3d& p) {
  if (!(DepthOf(p) > 0) || !(DepthOf(tip_) > 0)) entry_ = OnPlane(p);
  tip_ = p;
}

void VirtualSlave::Follow(const OperatorCommand& command) {
  command_sequence_ = command.sequence;
  echo_ = command.sent_at;
  if (command.epoch != epoch_) {
    epoch_ = command.epoch;
    mapping_ = options_.transform;
    mapping_.ZeroOffset(command.p_M, tip_);
  }
  engaged_ = command.engaged;
  if (engaged_) MoveTo(mapping_.ToSlave(command.p_M));
}

void VirtualSlave::TakeSample(Time now) {
  sensed_at_ = now;
  sensed_tip_ = tip_;
  window_forces_.push_back(ForceAt(tip_));
  if (window_forces_.size() > static_cast<std::size_t>(options_.window)) window_forces_.pop_front();
  sensed_force_.setZero();
  for (const Eigen::Vector3d& f : window_forces_)
    sensed_force_ += f / static_cast<double>(window_forces_.size());
}

SlaveState VirtualSlave::Compose(Time now) const {
  SlaveState state;
  state.sequence = state_sequence_;
  state.sensed_at = sensed_at_ + Seconds(options_.clock_offset);
  state.sent_at = now + Seconds(options_.clock_offset);
  state.p_S_tip = sensed_tip_;
  state.force = sensed_force_;
  state.validity = validity;
  const Eigen::Vector3d& n = options_.normal;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - n * n.transpose();
  state.local_model.reference = entry_;
  state.local_model.normal = n;
  state.local_model.stiffness = options_.K * n * n.transpose() + options_.shear * across;
  state.local_model.valid_radius = 0.05;
  state.local_model.revision = revision_;
  state.local_model.in_contact = sensed_force_.dot(n) > 0;
  state.command_sequence = command_sequence_;
  if (command_sequence_ > 0) state.echo = echo_;
  state.echo_delay = std::max(0.0, SecondsBetween(taken_at_, now));
  state.epoch = forgets ? 0 : epoch_;
  state.offset = mapping_.offset;
  state.phase = engaged_ ? Phase::kFollowing : Phase::kClutched;
  if (forced_phase == Phase::kEstop) state.phase = forced_phase;
  state.true_force = ForceAt(tip_);
  if (!options_.several) return state;
  state.finger_count = 2;
  for (int i = 0; i < 2; ++i) {
    FingerState& finger = state.fingers[static_cast<std::size_t>(i)];
    finger.p_S_contact = entry_.cast<float>();
    finger.force = (sensed_force_ / (1 + i)).cast<float>();
    finger.in_contact = state.local_model.in_contact;
    finger.validity = validity;
  }
  return state;
}

}  // namespace palpate
