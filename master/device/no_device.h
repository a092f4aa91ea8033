// Stands in for a device where the master only observes.
#pragma once

#include <string>

#include "master/device/haptic_device.h"

namespace palpate {

// Is never engaged, and renders nothing.
class NoDevice final : public HapticDevice {
 public:
  NoDevice() : HapticDevice({.simulated = true}) {}
  [[nodiscard]] std::string description() const override { return "none: this master observes"; }

 protected:
  DeviceReading DoRead(Time now) noexcept override { return {.at = now}; }
  DeviceOutput DoWrite(const Wrench& /*wrench*/) noexcept override { return DeviceOutput::kOff; }
};

}  // namespace palpate
