// Connects a force-feedback driver to a fake of its vendor's software, a haptic loop and a virtual
// slave. All use the fake's injected clock.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "master/device/haptic_device.h"
#include "master/device/sim_hand.h"
#include "tests/master/haptics/rig.h"

namespace palpate {

constexpr double kBenchTick = 0.001;  // [s]
constexpr double kSlewPerTick = 0.2;  // [N]
constexpr double kForceLimit = 3.3;   // of the master [N]

// One tick of a press.
struct PressTick {
  Eigen::Vector3d p_M{0, 0, 0}, sent{0, 0, 0};
  bool engaged = false;
};

// The simulated operator's press against the virtual slave's wall, 4 s, at a peak `speed` [m/s].
inline std::vector<PressTick> SimulatedPress(double speed = 0.020) {
  Rig rig({}, RenderMode::kLocal, kForceLimit, kSlewPerTick);
  SimHand hand(0.004, speed);
  std::vector<PressTick> ticks;
  for (int i = 0; i < 4000; ++i) {
    const TickRecord& record = rig.Tick(hand);
    ticks.push_back(
        {record.p_M, record.chain.sent,
         record.state == OperatorState::kAligning || record.state == OperatorState::kFollowing});
  }
  return ticks;
}

class DeviceBench {
 public:
  virtual ~DeviceBench() = default;
  DeviceBench(const DeviceBench&) = delete;
  DeviceBench& operator=(const DeviceBench&) = delete;

  virtual void Open() = 0;
  // Simulates one millisecond.
  virtual const TickRecord& Step() = 0;
  // Force that the motors make now, M [N].
  [[nodiscard]] virtual Eigen::Vector3d Made() const = 0;
  // Makes the handle follow `press` from now on.
  virtual void Follow(const std::vector<PressTick>& press) = 0;
  virtual void Switch(bool is_closed) = 0;
  virtual void Unplug() = 0;
  virtual void Replug() = 0;
  // Allocations of driver and haptic loop so far, without the virtual slave.
  [[nodiscard]] virtual long allocations() const = 0;

  // Plays `press` with the switch as its operator had it, until `ticks`.
  void Play(const std::vector<PressTick>& press, std::size_t ticks,
            const std::function<void(std::size_t)>& each = {}) {
    Follow(press);
    for (std::size_t i = 0; i < ticks; ++i) {
      if (i == 0 || press[i].engaged != press[i - 1].engaged) Switch(press[i].engaged);
      Step();
      if (each) each(i);
    }
  }

  Rig rig{{}, RenderMode::kLocal, kForceLimit, kSlewPerTick};
  std::unique_ptr<HapticDevice> device;

 protected:
  DeviceBench() = default;
};

}  // namespace palpate
