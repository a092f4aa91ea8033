#include "master/haptics/operator_machine.h"

#include "master/haptics/tick_message.h"

namespace palpate {

using enum OperatorState;

std::string_view ToString(OperatorState state) {
  constexpr std::string_view kPrefix = "OPERATOR_PHASE_";
  return std::string_view(v1::OperatorPhase_Name(ToProto(state))).substr(kPrefix.size());
}

OperatorState OperatorMachine::Step(const Input& in) noexcept {
  if (!in.engaged) armed_ = true;
  const OperatorState next = Next(in);
  if (next != state_) since_ = in.now;
  return state_ = next;
}

bool OperatorMachine::commands_engaged() const noexcept {
  return state_ == kAligning || state_ == kFollowing || state_ == kHold;
}

OperatorState OperatorMachine::Next(const Input& in) noexcept {
  const bool is_known = in.state_age <= kDisconnectAfter, is_linked = is_known && !in.observed;
  const bool fresh = in.state_age <= dead_after_ && !in.observed;
  const bool sound = fresh && in.trusted && in.force_known && in.slave_epoch == epoch_ &&
                     in.slave_phase == Phase::kFollowing;
  const bool is_stopped = is_known && in.slave_phase == Phase::kEstop;
  if (in.stop || is_stopped) {
    armed_ = !in.engaged;
    return in.stop ? kStopRequested : kEstop;
  }
  switch (state_) {
    case kDisconnected:
      return fresh ? kReady : kDisconnected;
    case kReady:
    case kClutched:
      if (!is_linked) return kDisconnected;
      return fresh && in.trusted && in.engaged && armed_ ? Engage() : state_;
    case kAligning:
      if (!in.engaged || in.settings_wait || in.now - since_ > kAlignWithin + in.round_trip) {
        return kReady;
      }
      return sound ? kFollowing : kAligning;
    case kFollowing:
      if (!in.engaged) return kClutched;
      return sound ? kFollowing : kHold;
    case kHold:
      return is_linked || in.now - since_ <= kMaxHold ? NextInHold(in, fresh, sound)
                                                      : kDisconnected;
    case kEstop:
    case kStopRequested:
      return is_linked ? kReady : kDisconnected;
  }
  return kDisconnected;
}

OperatorState OperatorMachine::Engage() noexcept {
  armed_ = false;
  ++epoch_;
  return kAligning;
}

OperatorState OperatorMachine::NextInHold(const Input& in, bool fresh, bool sound) noexcept {
  if (!in.engaged) return kClutched;
  if (in.now - since_ <= kMaxHold) return sound ? kFollowing : kHold;
  return fresh && in.force_known ? kReady : kHold;
}

}  // namespace palpate
