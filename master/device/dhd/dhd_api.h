// The part of the DHD (Force Dimension SDK) that the driver calls, from libdhd.so. Declared here in
// our own words. Each function takes the device's number last.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "master/device/search/shared_library.h"

namespace palpate {

// Results of a call. Negative: an error.
namespace dhd {
inline constexpr int kOk = 0;
inline constexpr int kTimeGuard = 1;                     // no new data since the last call
inline constexpr int kSaturated = 2;                     // the motors are at their limit
inline constexpr int kCommunication = 2, kNoDevice = 5;  // numbers of the last error
inline constexpr int kStatusForce = 5, kStatusForceOffCause = 14;  // places in the status
}  // namespace dhd

struct DhdApi {
  // Returns why it cannot be used; empty: every function is set.
  std::string Load(const LibrarySearch& search);

  int (*device_count)() = nullptr;
  int (*open)() = nullptr;
  int (*open_serial)(int) = nullptr;
  int (*close)(char) = nullptr;
  int (*stop)(char) = nullptr;
  const char* (*system_name)(char) = nullptr;
  void (*sdk_version)(int*, int*, int*, int*) = nullptr;
  const char* (*last_error_text)() = nullptr;
  int (*last_error)() = nullptr;
  bool (*has_wrist)(char) = nullptr;
  bool (*has_active_wrist)(char) = nullptr;
  bool (*has_gripper)(char) = nullptr;
  int (*enable_force)(unsigned char, char) = nullptr;
  int (*position)(double*, double*, double*, char) = nullptr;
  int (*velocity)(double*, double*, double*, char) = nullptr;
  int (*orientation)(double (*)[3], char) = nullptr;
  int (*gripper_gap)(double*, char) = nullptr;
  unsigned (*buttons)(char) = nullptr;
  int (*set_force)(double, double, double, char) = nullptr;
  int (*set_force_and_torque)(double, double, double, double, double, double, char) = nullptr;
  int (*status)(int*, char) = nullptr;
  // Optional: older releases lack them.
  double (*max_force)(char) = nullptr;
  int (*rendered_force)(double*, double*, double*, char) = nullptr;
};

// Lists where libdhd.so may be: `folders`, then $FORCEDIM_SDK, then where the system looks.
LibrarySearch DhdSearch(std::vector<std::filesystem::path> folders);

}  // namespace palpate
