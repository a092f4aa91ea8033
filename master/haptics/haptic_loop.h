// The haptic loop renders one force per millisecond, independent of slave and link, and zero at the
// end. It exchanges data with other threads through wait-free latest-value slots and a ring.
#pragma once

#include <limits>
#include <optional>
#include <stop_token>

#include "master/device/device.h"
#include "master/haptics/force_chain.h"
#include "master/haptics/operator_machine.h"
#include "master/haptics/operator_requests.h"
#include "master/haptics/periodic.h"
#include "master/haptics/received.h"
#include "master/haptics/renderer.h"
#include "master/haptics/spsc_ring.h"
#include "master/haptics/stop_path.h"
#include "master/haptics/tare.h"
#include "master/haptics/tick_record.h"
#include "master/motion/operator_motion.h"
#include "shared/link/clock_offset.h"
#include "shared/link/latest_value.h"

namespace palpate {

class HapticLoop {
 public:
  struct Options {
    RenderMode render = RenderMode::kLocal;
    TeleopTransform transform;  // scales and rotation; the offset comes with the states
    // Bounds of the master, which no other program can raise.
    double force_limit = 3.3;  // on the device [N], > 0; limits of scene and device also apply
    double slew_limit = 0.2;   // of the force, in both directions [N/ms], > 0
    double max_age = 0.2;      // of a rendered sample, without its network delay [s]
    // Limit of the network delay that is added to it [s].
    double max_trip = std::numeric_limits<double>::infinity();
    double dead_after = kUsualDeadAfter;                 // link timeout without a state [s]
    std::uint32_t settings_revision = 0;                 // of the settings that `transform` is from
    double stiffest = PassivityControl::kMaxStiffness;   // rendered at the device [N/m], > 0
    double max_damping = PassivityControl::kMaxDamping;  // of the device [N s/m]
    MotionOptions motion = {};                           // axes, locks, box, fixtures
    bool sends_orientation = false;                      // the device measures one
    bool renders_torque = false;                         // the device has actuators for it
  };
  struct Slots {
    LatestValue<ReceivedState>* states = nullptr;      // read here
    LatestValue<OperatorCommand>* commands = nullptr;  // written here
    SpscRing<TickRecord>* records = nullptr;           // written here
    LatestValue<RemoteSettings>* settings = nullptr;   // read here; null: fixed settings
    LatestValue<ReceivedPatch>* patches = nullptr;     // read here; null: no patches
    const OperatorRequests* requests = nullptr;        // read here; null: no requests
  };
  struct Stats {
    PeriodicStats periodic;
    LatencyHistogram compute_us;  // of Read, Tick, WriteForce and Guide together [us]
  };

  // All `slots` must outlive the loop. Throws std::invalid_argument if a limit or scale is not > 0.
  HapticLoop(const Options& options, const Slots& slots);

  // Runs for `length`, until `stop`, or until the device's motion ends. The force then fades, and
  // the last force is zero.
  void Run(Device& device, Clock::duration length, const std::stop_token& stop) noexcept;

  // Runs one tick and returns the force on the device [N] for its `reading` at `now`, both along
  // its own axes. The force is finite and within the limit. Does not allocate, lock or wait.
  Eigen::Vector3d Tick(const DeviceReading& reading, Time now) noexcept;
  // The operator's settings. Its guide is unknown unless following.
  [[nodiscard]] const OperatorMotion& motion() const noexcept { return motion_; }
  // Returns the emergency stops; a request disengages.
  [[nodiscard]] StopRequests& stops() noexcept { return stops_; }
  // Sends the command that disengages and leaves the tool in place. Call it after the last tick.
  void Release(Time now) noexcept;

  // Returns the values of the last tick. Thread-safe after Run.
  [[nodiscard]] const TickRecord& record() const noexcept { return record_; }
  [[nodiscard]] const PassivityControl& passivity() const noexcept { return passivity_; }
  [[nodiscard]] const Stats& stats() const noexcept { return stats_; }

 private:
  void TakeState(Time now) noexcept;
  void TakeRequests() noexcept;
  void TakeSettings() noexcept;
  void TakePatch(double now) noexcept;
  void CompareWithSlave(const SlaveState& state) noexcept;
  // Returns whether the newest state may be rendered. Adds the reason if not.
  [[nodiscard]] bool IsNewestStateUsable(Time now) noexcept;
  [[nodiscard]] bool KeepsOffset() noexcept;
  [[nodiscard]] DeviceReading Checked(const DeviceReading& reading) noexcept;
  void StepMachine(Time now, bool engaged) noexcept;
  void OnStateChange(OperatorState to) noexcept;
  void FadeOutOfHold(double now) noexcept;
  // `command`: the part of `reading` that is commanded.
  void RunChain(const DeviceReading& reading, const DeviceReading& command, double now,
                double dt) noexcept;
  // Returns a command that leaves the tool at its last commanded position.
  [[nodiscard]] OperatorCommand NextCommand(Time now) noexcept;
  void PutCommand(const DeviceReading& wanted, Time now) noexcept;

  Options options_;
  Slots slots_;
  Renderer renderer_;
  OperatorMachine machine_;
  OperatorMotion motion_;
  PassivityControl passivity_;
  OutputBlend output_;
  Tare tare_;
  TeleopTransform transform_;  // with the offset of the current epoch
  std::optional<ReceivedState> newest_;
  BaseRoundTrip base_trip_;
  Time learned_at_{};                     // the time of the last `base_trip_.Learn`
  const ReceivedPatch* patch_ = nullptr;  // the newest, in its slot; null: already used
  Time judged_at_{};                      // sample time of the last comparison, slave's clock
  RemoteSettings settings_;               // read last
  std::uint32_t used_revision_;           // of the settings that `transform_` is from
  bool settings_wait_ = false;            // wait until the operator is disengaged
  std::uint32_t offset_epoch_ = 0;        // epoch of the transform's offset
  DeviceReading last_reading_;            // the last good one
  OperatorCommand commanded_;             // sequence, position and orientation of the last one
  Eigen::Vector3d sent_{0, 0, 0};
  StopRequests stops_;
  bool hold_is_fading_ = false;
  TickClock clock_;
  TickRecord record_;
  Stats stats_;
};

}  // namespace palpate
