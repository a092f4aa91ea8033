// A haptic device, or what stands in for one. Polled by the haptic loop.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

// What the device says at one tick. Frame M.
struct DeviceReading {
  Eigen::Vector3d p_M{0, 0, 0};  // tip [m]
  Eigen::Vector3d v_M{0, 0, 0};  // velocity [m/s]
  bool engaged = false;          // dead-man's switch closed: the operator wants to follow
};

// What a scripted device may know of the world to act sensibly: where the surface is, in its own
// frame.
struct DeviceGuide {
  bool known = false;
  Eigen::Vector3d inward_M{0, -1, 0};  // unit direction into the object
  double gap_M = 0;       // distance from the tip to the surface along it [m]; negative inside
  double round_trip = 0;  // of the line, as known even where the surface is not [s]
};

class Device {
 public:
  // A driver that gets no force for so long shows none, by itself: whoever should renew it may have
  // stopped, and a hand must not be held by nobody [s].
  static constexpr double kLetGoAfter = 0.020;

  virtual ~Device() = default;
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  // Reads the tip at `now`. Real-time safe: no allocation, lock or wait.
  virtual DeviceReading Read(Time now) noexcept = 0;
  // Shows `force_M` [N], the force on the hand, for kLetGoAfter at most. Real-time safe. Zero at
  // the end.
  virtual void WriteForce(const Eigen::Vector3d& force_M) noexcept = 0;
  // Tells where the surface is; scripted devices use it, real ones ignore it. Real-time safe.
  virtual void Guide(const DeviceGuide& guide) noexcept = 0;
  // The motion is over (a recording has ended). Real-time safe.
  [[nodiscard]] virtual bool finished() const noexcept = 0;
  [[nodiscard]] virtual std::string description() const = 0;
  [[nodiscard]] virtual double force_limit() const = 0;  // of the device itself [N]
};

// `spec`: `sim-hand` or `playback:FILE.csv`. `press_depth`, `press_speed` in M [m], [m/s] for the
// scripted hand. Throws std::invalid_argument: unknown device (lists what exists);
// std::runtime_error: file:line of a bad recording.
std::unique_ptr<Device> OpenDevice(const std::string& spec, double press_depth, double press_speed);

// The file that a device of `spec` plays; empty: it plays none.
std::filesystem::path PlaybackFile(const std::string& spec);

}  // namespace palpate
