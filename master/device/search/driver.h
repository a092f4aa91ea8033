// Driver is the interface that each driver offers to `--device` and to `palpate-master devices`.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "master/device/haptic_device.h"
#include "master/device/search/shared_library.h"

namespace palpate {

// Whether a driver can be used here, in words for the operator.
struct DriverReport {
  std::vector<std::string> searched, found, missing;
  std::string next;     // what to do; empty: nothing
  bool usable = false;  // `connect --device NAME` would start now
};

struct Driver {
  std::string_view name;     // of --device
  std::string_view devices;  // which it drives
  std::string_view option;   // meaning of the text after the colon
  // May open the device to read it; writes no force. Does not throw.
  DriverReport (*examine)();
  // Throws DeviceUnavailable, or std::invalid_argument for a wrong option.
  std::unique_ptr<HapticDevice> (*open)(const std::string& option);
};

// A device that cannot be opened, with the reason and the next step.
class DeviceUnavailable : public std::runtime_error {
 public:
  DeviceUnavailable(const std::string& name, const std::string& why)
      : std::runtime_error("--device " + name + ": " + why +
                           "; palpate-master devices shows what was searched and what to do"),
        reason_(why) {}
  [[nodiscard]] const std::string& reason() const { return reason_; }

 private:
  std::string reason_;
};

// Adds what was searched and found of `library`.
void AddLibrary(const LibrarySearch& search, const SharedLibrary& library, DriverReport* report);
// Opens the device of `driver`, and adds its capabilities and calibration, or why it does not open.
// Waits for a reading, up to a fifth of a second. It writes no force.
void AddOpened(const Driver& driver, DriverReport* report);

}  // namespace palpate
