// Everything worth knowing about one tick, as it leaves the haptic loop for log, report and view.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "master/haptics/force_chain.h"
#include "master/haptics/operator_machine.h"
#include "master/haptics/render_mode.h"
#include "master/haptics/tare.h"
#include "shared/state/clock.h"
#include "shared/state/slave_state.h"

namespace palpate {

struct TickRecord {
  Time at{};
  OperatorState state = OperatorState::kDisconnected;
  Eigen::Vector3d p_M{0, 0, 0};  // device tip [m]
  Eigen::Vector3d p_S{0, 0, 0};  // T^p of it, or the slave's tip while not following [m]
  ForceChain chain;
  double state_age = -1;   // since the newest state was received [s]; negative: none yet
  double sensed_age = -1;  // since its sample was taken, by the clocks' offset [s]; likewise
  double round_trip = 0;   // with the newest state [s]; 0: none with this tick
  std::uint32_t epoch = 0;
  std::uint64_t state_sequence = 0;  // of the newest state; 0: none yet
  // What each fingertip feels, by the newest state; one: the tool alone. 0: no state yet.
  std::array<FingerState, kMaxFingers> fingers;
  int finger_count = 0;
  // True force that came with a state first seen at this tick: simulated sites only.
  bool has_truth = false;
  Time truth_at{};                 // master's clock
  Time truth_commanded_at{};       // when the newest command that the slave then had left; 0: none
  Eigen::Vector3d truth{0, 0, 0};  // S [N]
  std::uint32_t marks = 0;         // events that the operator marked so far
  RenderMode render = RenderMode::kLocal;
  bool clutched = false;  // the operator let go, whatever the device's switch says
  TareState tare_state = TareState::kNone;
  Eigen::Vector3d tare{0, 0, 0};  // what `estimated` is less than the slave told, S [N]
  // Of the newest state: when its sample was taken, and when it left. Slave's clock.
  Time sensed_at{}, sent_at{};
  // What the hand goes by [-], [-], [N]; 0: not told.
  double position_scale = 0, force_scale = 0, force_limit = 0;
  double energy = 0;  // that the hand put in, less what it got out, at its port [J]; NaN: unknown
  Eigen::Vector3d p_S_tip{NAN, NAN, NAN};  // by the newest state [m]; NaN: none yet
};

// What the fingertips feel by `state`; a tool that has none is one itself. Real-time safe.
void RecordFingers(const SlaveState& state, TickRecord* record) noexcept;

}  // namespace palpate
