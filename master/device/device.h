// Interface of a haptic device or its substitute. The haptic loop polls it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

// Reading of the device at one tick. Frame M.
struct DeviceReading {
  Eigen::Vector3d p_M{0, 0, 0};  // tip [m]
  Eigen::Vector3d v_M{0, 0, 0};  // velocity [m/s]
  bool engaged = false;          // the dead-man's switch is closed: the operator wants to follow
};

// What a scripted device may know of the scene: the position of the surface, in frame M.
struct DeviceGuide {
  bool known = false;
  Eigen::Vector3d inward_M{0, -1, 0};  // unit direction into the object
  double gap_M = 0;       // distance from the tip to the surface along it [m]; negative inside
  double round_trip = 0;  // of the link [s]; set even if `known` is false
};

class Device {
 public:
  // Timeout of a driver [s]: without a new force it sets the force to zero, because the program may
  // have stopped.
  static constexpr double kLetGoAfter = 0.020;

  virtual ~Device() = default;
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  // Reads the tip at `now`. Real-time safe: no allocation, lock or wait.
  virtual DeviceReading Read(Time now) noexcept = 0;
  // Renders `force_M` [N], for at most kLetGoAfter. The last force is zero. Real-time safe.
  virtual void WriteForce(const Eigen::Vector3d& force_M) noexcept = 0;
  // Sets the position of the surface. Scripted devices use it, real ones ignore it. Real-time safe.
  virtual void Guide(const DeviceGuide& guide) noexcept = 0;
  // The motion is over (a recording has ended). Real-time safe.
  [[nodiscard]] virtual bool finished() const noexcept = 0;
  [[nodiscard]] virtual std::string description() const = 0;
  [[nodiscard]] virtual double force_limit() const = 0;  // of the device itself [N]
};

// Opens `spec`: `sim-hand` or `playback:FILE.csv`. `press_depth` [m] and `press_speed` [m/s] of the
// simulated operator are in frame M. Throws std::invalid_argument for an unknown device, and
// std::runtime_error with file:line for an invalid recording.
std::unique_ptr<Device> OpenDevice(const std::string& spec, double press_depth, double press_speed);

// The file that `spec` plays; empty if it is no playback.
std::filesystem::path PlaybackFile(const std::string& spec);

}  // namespace palpate
