// A haptic loop, a virtual slave and a device on one virtual clock.
#pragma once

#include <cmath>
#include <functional>

#include "master/haptics/haptic_loop.h"
#include "tests/master/haptics/test_device.h"
#include "tests/master/haptics/virtual_slave.h"

namespace palpate {

// A device whose position the test sets.
class Puppet final : public TestDevice {
 public:
  DeviceReading reading;
  Eigen::Vector3d force{0, 0, 0};
  DeviceGuide guide;

  DeviceReading Read(Time) noexcept override { return reading; }
  void WriteWrench(const Eigen::Vector3d& force_M,
                   const Eigen::Vector3d& /*torque_M*/) noexcept override {
    force = force_M;
  }
  void Guide(const DeviceGuide& next) noexcept override { guide = next; }
};

// Tests of force laws run without the slew limit, which devices that jump would meet.
inline constexpr double kNoSlewLimit = 1e6;  // [N/ms]

class Rig {
 public:
  explicit Rig(const VirtualSlave::Options& slave_options = {},
               RenderMode render = RenderMode::kLocal, double force_limit = 3.3,
               double slew_limit = kNoSlewLimit)
      : Rig({render, slave_options.transform, force_limit, slew_limit}, slave_options) {}
  explicit Rig(const HapticLoop::Options& options, const VirtualSlave::Options& slave_options = {})
      : slave(slave_options),
        loop(options, {&states, &commands, &records, &settings, &patches, &requests}) {
    requests.render = options.render;
  }

  // Runs one tick with `device` and returns its record.
  const TickRecord& Tick(Device& device) {
    now += kHapticPeriod;
    slave.Step(now, &commands, &states);
    device.WriteForce(loop.Tick(device.Read(now), now));
    device.Guide(loop.motion().guide());
    TickRecord drained;
    while (records.Pop(&drained)) {
    }
    return loop.record();
  }
  // Runs `seconds` of ticks and calls `each` with every record.
  void Run(Device& device, double seconds,
           const std::function<void(const TickRecord&)>& each = {}) {
    const Time end = now + Seconds(seconds);
    while (now < end) {
      const TickRecord& record = Tick(device);
      if (each) each(record);
    }
  }
  // Runs `seconds` with the switch closed, and with it open.
  void Engage(Puppet& puppet, double seconds) {
    puppet.reading.engaged = true;
    Run(puppet, seconds);
  }
  void Release(Puppet& puppet, double seconds) {
    puppet.reading.engaged = false;
    Run(puppet, seconds);
  }
  // Moves `puppet` straight to `p_M` at 20 mm/s, so that the energy of a press is supplied
  // by the operator.
  void Glide(Puppet& puppet, const Eigen::Vector3d& p_M) {
    constexpr double kStep = 20e-6;  // [m]
    const Eigen::Vector3d way = p_M - puppet.reading.p_M;
    const int steps = static_cast<int>(std::ceil(way.norm() / kStep));
    const Eigen::Vector3d from = puppet.reading.p_M;
    puppet.reading.v_M = way.normalized() * kStep / 0.001;
    for (int i = 1; i <= steps; ++i) {
      puppet.reading.p_M = from + way * i / steps;
      Tick(puppet);
    }
    puppet.reading.v_M.setZero();
  }
  [[nodiscard]] double t() const { return SecondsBetween(Time{std::chrono::hours(1)}, now); }
  [[nodiscard]] OperatorState state() const { return loop.record().state; }

  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  LatestValue<ReceivedPatch> patches;
  SpscRing<TickRecord> records{64};
  OperatorRequests requests{RenderMode::kLocal};
  VirtualSlave slave;
  HapticLoop loop;
  Time now{std::chrono::hours(1)};
};

}  // namespace palpate
