// The operator states: when the tool may follow, and when a force may be rendered.
//
//   DISCONNECTED <-> READY -> ALIGNING -> FOLLOWING <-> CLUTCHED
//                      ^                   |   ^
//                      +----- HOLD <-------+   | back within 250 ms
//                              +---------------+
//   STOP_REQUESTED from any state, until a state of the slave answers the request.
//   ESTOP from any state, while the states of the slave say so.
//
// Following requires a deliberate act: the dead-man's switch must be open, and then closed. Each
// closing begins a new epoch, in which the slave sets the offset so that the tool does not move.
#pragma once

#include <cstdint>
#include <string_view>

#include "shared/state/dead_after.h"
#include "shared/state/slave_state.h"

namespace palpate {

enum class OperatorState : std::uint8_t {
  kDisconnected,  // no states from the slave
  kReady,         // the operator may engage
  kAligning,      // engaged, waiting for the slave to accept the epoch
  kFollowing,     // the tool follows, the force is rendered
  kClutched,      // the operator disengaged after following
  kHold,   // states late or not trusted, force unknown, or the tool not following: the force is
           // held, then fades
  kEstop,  // the slave reports its emergency stop
  kStopRequested,  // this master requested it, and no state of the slave has answered
};
inline constexpr std::size_t kOperatorStateCount = 8;
std::string_view ToString(OperatorState state);  // `FOLLOWING`, ...

class OperatorMachine {
 public:
  static constexpr double kMaxHold =
      0.250;  // HOLD ends by itself within this time; later a new engagement is needed [s]
  static constexpr double kAlignWithin =
      1.0;  // plus a round trip, for the slave to accept an epoch [s]
  static constexpr double kDisconnectAfter = 1.0;  // time without a state [s]

  struct Input {
    double now = 0;            // [s]
    bool engaged = false;      // the device's dead-man's switch
    double state_age = 1e9;    // since a state was received [s]
    double round_trip = 0;     // [s]
    bool force_known = false;  // in the newest state
    bool stop = false;         // an emergency stop was requested, and no state has answered it
    bool observed = false;  // the newest state is that of a slave that this master does not operate
    bool trusted = true;    // the newest state may be rendered
    bool settings_wait = false;  // new settings wait for the operator to be disengaged
    std::uint32_t slave_epoch = 0;
    Phase slave_phase = Phase::kReady;
  };
  // Sets the link timeout without a state [s]. Call it between two ticks.
  void set_dead_after(double seconds) noexcept { dead_after_ = seconds; }
  [[nodiscard]] double dead_after() const noexcept { return dead_after_; }
  // Advances the state by one tick. Real-time safe.
  OperatorState Step(const Input& in) noexcept;

  [[nodiscard]] OperatorState state() const noexcept { return state_; }
  [[nodiscard]] double since() const noexcept { return since_; }         // when `state` began [s]
  [[nodiscard]] std::uint32_t epoch() const noexcept { return epoch_; }  // 0: none yet
  // Returns whether commands request the tool to follow.
  [[nodiscard]] bool commands_engaged() const noexcept;

 private:
  OperatorState Next(const Input& in) noexcept;
  OperatorState Engage() noexcept;
  OperatorState NextInHold(const Input& in, bool fresh, bool sound) noexcept;

  OperatorState state_ = OperatorState::kDisconnected;
  double dead_after_ = kUsualDeadAfter;
  double since_ = 0;
  std::uint32_t epoch_ = 0;
  bool armed_ = false;  // the switch has been open since the last engagement
};

}  // namespace palpate
