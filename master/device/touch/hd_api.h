// The part of the HDAPI (OpenHaptics) that the driver calls, from libHD.so. Declared here in our
// own words: names, argument types and numbers are facts of the interface.
#pragma once

#include <filesystem>
#include <vector>

#include "master/device/search/shared_library.h"

namespace palpate {

// An error of the library, which it returns by value.
struct HdError {
  unsigned code = 0;  // 0: none
  int internal = 0;
  unsigned handle = 0;
};

// Parameters and values, by the numbers of the interface.
namespace hd {
inline constexpr unsigned kButtons = 0x2000, kPosition = 0x2050, kVelocity = 0x2051,
                          kTransform = 0x2052, kAngularVelocity = 0x2053;  // readings
inline constexpr unsigned kModel = 0x2501, kSerial = 0x2504;               // texts
inline constexpr unsigned kUsableWorkspace = 0x2551, kInputDof = 0x2553, kOutputDof = 0x2554,
                          kUpdateRate = 0x2600, kMaxStiffness = 0x2602, kMaxForce = 0x2603,
                          kMaxContinuousForce = 0x2604, kMotorTemperature = 0x2605,
                          kMaxDamping = 0x2609;  // properties
inline constexpr unsigned kCurrentForce = 0x2700;
inline constexpr unsigned kForceOutput = 0x4000, kMaxForceClamping = 0x4001,
                          kSoftwareForceLimit = 0x4003;  // switches
inline constexpr unsigned kCalibrated = 0x5000, kNeedsUpdate = 0x5001, kNeedsManual = 0x5002;
inline constexpr unsigned kEncoderReset = 1, kAutomatic = 2, kInkwell = 4;  // ways to calibrate
inline constexpr unsigned kInvalidHandle = 0xFFFFFFFF;
inline constexpr unsigned kInvalidParameter = 0x100;  // a model has no such parameter
inline constexpr unsigned kWarmMotors = 0x200, kExceededMaxForce = 0x201, kExceededImpulse = 0x202,
                          kExceededVelocity = 0x203, kForceError = 0x204, kDeviceFault = 0x300,
                          kCommunication = 0x302;  // errors
}  // namespace hd

struct HdApi {
  // Returns why it cannot be used; empty: every function is set.
  std::string Load(const LibrarySearch& search);

  unsigned (*init_device)(const char*) = nullptr;
  void (*make_current)(unsigned) = nullptr;
  void (*disable_device)(unsigned) = nullptr;
  void (*begin_frame)(unsigned) = nullptr;
  void (*end_frame)(unsigned) = nullptr;
  HdError (*get_error)() = nullptr;
  const char* (*error_text)(unsigned) = nullptr;
  void (*enable)(unsigned) = nullptr;
  void (*disable)(unsigned) = nullptr;
  void (*get_integers)(unsigned, int*) = nullptr;
  void (*get_doubles)(unsigned, double*) = nullptr;
  const char* (*get_text)(unsigned) = nullptr;
  void (*set_doubles)(unsigned, const double*) = nullptr;
  unsigned (*check_calibration)() = nullptr;
  unsigned (*calibration_style)() = nullptr;
  void (*update_calibration)(unsigned) = nullptr;
  void (*start_scheduler)() = nullptr;
  void (*stop_scheduler)() = nullptr;
  unsigned long (*schedule)(unsigned (*)(void*), void*, unsigned short) = nullptr;
  void (*unschedule)(unsigned long) = nullptr;
};

// Lists where libHD.so may be: `folders`, then $GTDD_HOME, then where the system looks.
LibrarySearch HdSearch(std::vector<std::filesystem::path> folders);

}  // namespace palpate
