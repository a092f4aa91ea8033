// Device is the interface between the haptic loop and a device: it returns readings and takes
// forces. Every driver derives from HapticDevice, which applies the last limits.
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "master/device/device_status.h"
#include "shared/state/clock.h"

namespace palpate {

// Reading of the device at one tick. Frame M: x to the right, y up, z towards the operator.
struct DeviceReading {
  Eigen::Vector3d p_M{0, 0, 0};  // tip [m]
  Eigen::Vector3d v_M{0, 0, 0};  // velocity [m/s]
  bool engaged = false;          // the dead-man's switch is closed: the operator wants to follow
  bool repeated = false;         // the device had no new data since the last reading
  Time at{};                     // when it was measured, master's clock
  Eigen::Quaterniond q_M{1, 0, 0, 0};  // orientation of the tip
  Eigen::Vector3d w_M{0, 0, 0};        // angular velocity [rad/s]
  DeviceStatus status = {};            // with a fault, the rest is not usable
};

// A scripted device may use this knowledge of the scene: the position of the surface, in frame M.
struct DeviceGuide {
  bool known = false;
  Eigen::Vector3d inward_M{0, -1, 0};  // unit direction into the object
  double gap_M = 0;       // distance from the tip to the surface along it [m]; negative inside
  double round_trip = 0;  // of the link [s]; set even if `known` is false
};

// The ranges that a device renders and measures. A value without a limit is infinite.
struct DeviceLimits {
  static constexpr double kUnlimited = std::numeric_limits<double>::infinity();

  double force = kUnlimited;        // of device and master [N]
  double torque = 0;                // [N m]; 0: not actuated
  double stiffness = kUnlimited;    // that it renders without buzzing [N/m]
  double damping = kUnlimited;      // that it renders stably [N s/m]
  double slew = kUnlimited;         // change of force that it accepts [N/ms]
  double rate = 0;                  // new readings per second [Hz]; 0: unknown
  bool senses_orientation = false;  // `q_M` of its readings is measured
};

class Device {
 public:
  // Timeout of a driver [s]: without a new force it sets the force to zero, because the program may
  // have stopped.
  static constexpr double kLetGoAfter = 0.020;
  // Runs one tick of the haptic loop at the given time. Real-time safe.
  using Tick = std::function<void(Time)>;

  virtual ~Device() = default;
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  // Reads the tip at `now`. Real-time safe: no allocation, lock or wait.
  virtual DeviceReading Read(Time now) noexcept = 0;
  // Renders a force [N], and a torque [N m] about the tip where it is actuated, for at most
  // kLetGoAfter. Real-time safe.
  virtual void WriteWrench(const Eigen::Vector3d& force_M,
                           const Eigen::Vector3d& torque_M) noexcept = 0;
  void WriteForce(const Eigen::Vector3d& force_M) noexcept {
    WriteWrench(force_M, Eigen::Vector3d::Zero());
  }
  // Sets the force to zero at once: the last call of a run. Real-time safe.
  virtual void DropForce() noexcept = 0;
  // Sets the position of the surface. Scripted devices use it, real ones ignore it. Real-time safe.
  virtual void Guide(const DeviceGuide& guide) noexcept = 0;
  // The motion is over (a recording has ended). Real-time safe.
  [[nodiscard]] virtual bool finished() const noexcept = 0;
  [[nodiscard]] virtual std::string description() const = 0;
  [[nodiscard]] virtual DeviceLimits limits() const = 0;
  // Sets the master's limit [N], which can only be lowered.
  virtual void LowerForceLimit(double limit) noexcept = 0;

  // Lets a thread of the device call `tick` once per period. Returns false if the device has no
  // thread, and the caller's thread polls. `tick` must stay valid until StopTicks.
  virtual bool StartTicks(const Tick* tick) = 0;
  // On return no thread of the device is inside `tick`, nor will be.
  virtual void StopTicks() = 0;
};

// Opens the device that `--device` names; `palpate-master devices` lists them. `press_depth` [m]
// and `press_speed` [m/s] of the simulated operator are in frame M. Throws std::invalid_argument
// for an unknown device or option, and std::runtime_error with the reason where it cannot be
// opened.
std::unique_ptr<Device> OpenDevice(const std::string& spec, double press_depth, double press_speed);

// The file that `spec` plays; empty if it is no playback.
std::filesystem::path PlaybackFile(const std::string& spec);

}  // namespace palpate
