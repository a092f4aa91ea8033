// A haptic loop, a virtual slave and a device on one virtual clock.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "master/haptics/haptic_loop.h"
#include "tests/master/haptics/virtual_slave.h"

namespace palpate {

// A device that goes where it is told.
class Puppet final : public Device {
 public:
  DeviceReading reading;
  Eigen::Vector3d felt{0, 0, 0};
  DeviceGuide guide;

  DeviceReading Read(Time) noexcept override { return reading; }
  void WriteForce(const Eigen::Vector3d& force_M) noexcept override { felt = force_M; }
  void Guide(const DeviceGuide& told) noexcept override { guide = told; }
  [[nodiscard]] bool finished() const noexcept override { return false; }
  [[nodiscard]] std::string description() const override { return "puppet"; }
  [[nodiscard]] double force_limit() const override { return 100; }
};

class Rig {
 public:
  explicit Rig(const VirtualSlave::Options& slave_options = {},
               RenderMode render = RenderMode::kLocal, double force_limit = 3.3)
      : slave(slave_options),
        loop({render, slave_options.transform, force_limit}, {&states, &commands, &records}) {}

  // One millisecond with `device`; what was recorded of it.
  const TickRecord& Tick(Device& device) {
    now += kHapticPeriod;
    slave.Step(now, &commands, &states);
    device.WriteForce(loop.Tick(device.Read(now), now));
    device.Guide(loop.guide());
    TickRecord drained;
    while (records.Pop(&drained)) {
    }
    return loop.record();
  }
  // `seconds` of it; `each` sees every tick.
  void Run(Device& device, double seconds,
           const std::function<void(const TickRecord&)>& each = {}) {
    const Time end = now + Seconds(seconds);
    while (now < end) {
      const TickRecord& record = Tick(device);
      if (each) each(record);
    }
  }
  [[nodiscard]] double t() const { return SecondsBetween(Time{std::chrono::hours(1)}, now); }
  [[nodiscard]] OperatorState state() const { return loop.record().state; }

  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  SpscRing<TickRecord> records{64};
  VirtualSlave slave;
  HapticLoop loop;
  Time now{std::chrono::hours(1)};
};

}  // namespace palpate
