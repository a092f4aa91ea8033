// State of a device beside its motion: calibration, output, faults, buttons. A copy travels with
// every reading to log, page and terminal.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

// Why a device gives no usable reading, or no force.
enum class DeviceFault : std::uint8_t {
  kNone,
  kNotCalibrated,  // its positions have no origin yet
  kSilent,         // no new reading for Device::kLetGoAfter
  kUnplugged,      // the device or its service is gone
  kForceOff,       // the device switched its force off by itself
  kHot,            // its motors are too warm
  kImpossible,     // numbers that are not finite, or beyond 100 m
  kDriver,         // another error of its driver
};
inline constexpr std::size_t kDeviceFaultCount = 8;
// `unplugged`; empty for kNone.
std::string_view InWords(DeviceFault fault);
// The next step of the operator; empty for kNone.
std::string_view NextStepOf(DeviceFault fault);

enum class CalibrationState : std::uint8_t {
  kNotNeeded,   // the device has an absolute origin, or none
  kCalibrated,  //
  kPending,     // the device calibrates by itself, for example in its inkwell
  kManual,      // the operator must move the device, see its guide
  kUnknown,     // not read yet
};
std::string_view InWords(CalibrationState calibration);
// Returns whether positions are usable.
inline bool IsUsable(CalibrationState calibration) {
  return calibration == CalibrationState::kNotNeeded ||
         calibration == CalibrationState::kCalibrated;
}

// States whether the last force was output.
enum class DeviceOutput : std::uint8_t {
  kOk,         // rendered as written
  kSaturated,  // rendered, but limited by the device class or by the device
  kOff,        // zero
};
std::string_view InWords(DeviceOutput output);

// Smallest force that is compared with the one a device renders [N]: smaller ones show no scale.
inline constexpr double kMinCompared = 0.1;

struct DeviceStatus {
  DeviceFault fault = DeviceFault::kNone;
  CalibrationState calibration = CalibrationState::kNotNeeded;
  DeviceOutput output = DeviceOutput::kOk;
  std::uint32_t buttons = 0;  // bit 0: the first button
  std::int32_t code = 0;      // of the vendor's library with `fault`; 0: none
  const char* cause = "";     // constant text with `fault`, of static lifetime
  float temperature = NAN;    // of the warmest motor, as a share of its limit [-]; NaN: unknown
  // Ratio of the rendered to the written force according to the device [-]; NaN: not reported.
  float force_share = NAN;
};

// Returns one line: `calibrated, output ok, buttons 1 3, motor 40 %`.
std::string InWords(const DeviceStatus& status);
// The fault with its cause and code: `unplugged: USB cable (code 0x302)`. Empty without a fault.
std::string FaultInWords(const DeviceStatus& status);

}  // namespace palpate
