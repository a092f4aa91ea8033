// Base of devices in tests of the haptic loop: without a limit, a thread or an end.
#pragma once

#include <string>

#include "master/device/device.h"

namespace palpate {

class TestDevice : public Device {
 public:
  void WriteWrench(const Eigen::Vector3d& /*force_M*/,
                   const Eigen::Vector3d& /*torque_M*/) noexcept override {}
  void DropForce() noexcept override { WriteForce(Eigen::Vector3d::Zero()); }
  void Guide(const DeviceGuide& /*guide*/) noexcept override {}
  [[nodiscard]] bool finished() const noexcept override { return false; }
  [[nodiscard]] std::string description() const override { return "test device"; }
  [[nodiscard]] DeviceLimits limits() const override { return {}; }
  void LowerForceLimit(double /*limit*/) noexcept override {}
  bool StartTicks(const Tick* /*tick*/) override { return false; }
  void StopTicks() override {}
};

}  // namespace palpate
