// The record of one tick, which the haptic loop passes to log, report and display.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "master/device/device_status.h"
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
  Eigen::Vector3d p_S{0, 0,
                      0};  // commanded tool position, or the slave's tip while not following [m]
  ForceChain chain;
  Eigen::Vector3d torque{0, 0, 0};  // for the device, before its limits, M [N m]
  double state_age = -1;            // since the newest state was received [s]; negative: none yet
  double sensed_age =
      // Time since its sample was taken, according to the clock offset [s]; negative: no sample
      // yet.
      -1;
  double round_trip = 0;  // with the newest state [s]; 0: none with this tick
  std::uint32_t epoch = 0;
  std::uint64_t state_sequence = 0;  // of the newest state; 0: none yet
  // Each fingertip of the newest state, or the single tool. None before the first state.
  std::array<FingerState, kMaxFingers> fingers;
  int finger_count = 0;
  // True force of a state that is new at this tick. Only simulated environments and sensors set it.
  bool has_truth = false;
  Time truth_at{};            // master's clock
  Time truth_commanded_at{};  // when the newest command that the slave had then was sent; 0: none
  Eigen::Vector3d truth{0, 0, 0};  // S [N]
  std::uint32_t marks = 0;         // events that the operator marked so far
  RenderMode render = RenderMode::kLocal;
  bool clutched = false;  // the clutch is open
  TareState tare_state = TareState::kNone;
  Eigen::Vector3d tare{0, 0, 0};  // tare subtracted from the slave's force, S [N]
  // Sample time and sending time of the newest state, slave's clock.
  Time sensed_at{}, sent_at{};
  // Active scales and force limit [-], [-], [N]; 0: unknown.
  double position_scale = 0, force_scale = 0, force_limit = 0;
  double model_stiffness =
      0;  // of the newest state's local model along its normal, S [N/m]; 0: none
  double energy =
      0;  // energy from the operator minus energy returned, at the device's port [J]; NaN: unknown
  DeviceStatus device;                     // with the reading of this tick
  Eigen::Vector3d p_S_tip{NAN, NAN, NAN};  // tip of the newest state [m]; NaN: none yet
};

// Copies the fingertips of `state`; a scene without any has the tool as one. Real-time safe.
void RecordFingers(const SlaveState& state, TickRecord* record) noexcept;

}  // namespace palpate
