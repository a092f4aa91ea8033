#include "master/device/device_status.h"

#include <array>

#include "shared/text/text.h"

namespace palpate {
namespace {

struct FaultWords {
  std::string_view name, next;
};
constexpr std::array<FaultWords, kDeviceFaultCount> kFaults{{
    {"", ""},
    {"not calibrated", "Calibrate the device as its guide says, then engage."},
    {"silent", "Check the cable and the power of the device, then engage again."},
    {"unplugged", "Plug the device in and start palpate-master again."},
    {"force switched off by the device",
     "Release the device, correct the cause, then engage again."},
    {"hot", "Let the motors cool, then engage again."},
    {"sends impossible numbers", "Check the cable of the device, then engage again."},
    {"driver error", "Run palpate-master devices, and restart the device."},
}};
constexpr std::array<std::string_view, 5> kCalibrations{"no calibration needed", "calibrated",
                                                        "calibrating", "needs calibration by hand",
                                                        "calibration unknown"};
constexpr std::array<std::string_view, 3> kOutputs{"ok", "saturated", "off"};

template <class Table, class Value>
const auto& Row(const Table& table, Value value) {
  return table[static_cast<std::size_t>(value)];
}

}  // namespace

std::string_view InWords(DeviceFault fault) {
  return Row(kFaults, fault).name;
}

std::string_view NextStepOf(DeviceFault fault) {
  return Row(kFaults, fault).next;
}

std::string_view InWords(CalibrationState calibration) {
  return Row(kCalibrations, calibration);
}

std::string_view InWords(DeviceOutput output) {
  return Row(kOutputs, output);
}

std::string InWords(const DeviceStatus& status) {
  std::string words =
      std::string(InWords(status.calibration)) + ", output " + std::string(InWords(status.output));
  if (std::isfinite(status.force_share)) {
    words +=
        Formatted(", renders %.0f %% of the force", 100 * static_cast<double>(status.force_share));
  }
  if (std::isfinite(status.temperature)) {
    words += Formatted(", motor %.0f %%", 100 * static_cast<double>(status.temperature));
  }
  if (status.buttons != 0) words += ", buttons";
  for (unsigned i = 0; i < 32; ++i) {
    if ((status.buttons >> i & 1U) != 0) words += " " + std::to_string(i + 1);
  }
  return words;
}

std::string FaultInWords(const DeviceStatus& status) {
  std::string words(InWords(status.fault));
  if (words.empty()) return words;
  if (*status.cause != '\0') words += std::string(": ") + status.cause;
  if (status.code != 0) words += Formatted(" (code 0x%x)", static_cast<unsigned>(status.code));
  return words;
}

}  // namespace palpate
