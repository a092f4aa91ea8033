// Base class of every driver: the last limits before a device, and the rules for when it may have a
// force at all. Drivers implement DoRead and DoWrite, and cannot leave a limit out.
//
//   |f| <= min(limit of the device, limit of the master),   |df| <= 0.2 N/ms
//   |t| <= limit of the device,   |dt| <= as fast to its limit as the force
//
// A TurnPassivity limits the energy of the torque. The force's energy is limited by the haptic
// loop. The force is zero, at once, without a calibration, before the first good reading, and from
// a fault on. A device that repeats its reading for 20 ms has the fault kSilent. After a fault the
// operator must open the switch before the device counts as engaged again.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "master/device/device.h"
#include "master/device/turn_passivity.h"

namespace palpate {

// Properties of a device. Values that it does not report are infinite; an unknown rate is 0.
struct DeviceCapabilities {
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();

  int sensed_dof = 3;
  int actuated_dof = 0;
  bool simulated = false;              // the force moves a model: the slew limit is the loop's
  double force = kUnknown;             // largest [N]
  double continuous_force = kUnknown;  // largest without a time limit [N]
  double torque = 0;                   // largest [N m]
  double continuous_torque = 0;        // largest without a time limit [N m]
  double stiffness = kUnknown;         // largest that it renders stably [N/m]
  double damping = kUnknown;           // largest that it renders stably [N s/m]
  Eigen::AlignedBox3d workspace;       // frame M [m]; empty: unknown
  double rate = 0;                     // of new readings [Hz]
};
// Returns one line: `6 axes sensed, 3 with force, up to 3.3 N, continuous 0.88 N, 500 N/m, 1000
// Hz`.
std::string InWords(const DeviceCapabilities& capabilities);

class HapticDevice : public Device {
 public:
  static constexpr double kSlew = 200;  // largest change of a real device's force [N/s]

  DeviceReading Read(Time now) noexcept final;
  // Renders force [N] and torque [N m], within the limits. Real-time safe.
  void WriteWrench(const Eigen::Vector3d& force_M, const Eigen::Vector3d& torque_M) noexcept final;
  void DropForce() noexcept final;
  void LowerForceLimit(double limit) noexcept final;
  void Guide(const DeviceGuide& /*guide*/) noexcept override {}
  [[nodiscard]] bool finished() const noexcept override { return false; }
  [[nodiscard]] DeviceLimits limits() const final;
  // A driver whose device has a thread of its own overrides both.
  bool StartTicks(const Tick* /*tick*/) override { return false; }
  void StopTicks() override {}
  [[nodiscard]] const DeviceCapabilities& capabilities() const noexcept { return capabilities_; }
  // The status of the last reading.
  [[nodiscard]] const DeviceStatus& status() const noexcept { return status_; }

 protected:
  // Forces within the limits, as a driver receives them. Frame M.
  struct Wrench {
    Eigen::Vector3d force{0, 0, 0};   // [N]
    Eigen::Vector3d torque{0, 0, 0};  // [N m]
  };

  explicit HapticDevice(const DeviceCapabilities& capabilities);

  // The present reading, or a fault in its status. `status` holds everything but `output`.
  // Real-time safe.
  virtual DeviceReading DoRead(Time now) noexcept = 0;
  // Renders `wrench`; a zero wrench must leave no force. kSaturated: the device limits it by
  // itself. Real-time safe.
  virtual DeviceOutput DoWrite(const Wrench& wrench) noexcept = 0;

 private:
  static constexpr int kAllAxes = 6;

  [[nodiscard]] bool senses_orientation() const { return capabilities_.sensed_dof >= kAllAxes; }
  [[nodiscard]] double torque_limit() const {
    return senses_orientation() && capabilities_.actuated_dof >= kAllAxes ? capabilities_.torque
                                                                          : 0;
  }
  void CheckReading(DeviceReading* reading) noexcept;
  [[nodiscard]] bool IsPossible(const DeviceReading& reading) const noexcept;

  const DeviceCapabilities capabilities_;
  double limit_;  // [N]
  DeviceStatus status_;
  bool usable_ = false;        // the last reading was good
  bool must_release_ = false;  // the switch must open before it counts as closed
  Time read_at_{}, new_at_{};  // of the last reading, and of the last new one
  Time written_at_{};          // time of the reading before the last force
  Wrench sent_;
  TurnPassivity turning_;
};

}  // namespace palpate
