// Force Dimension omega, delta, sigma, lambda and the Novint Falcon through the Force Dimension SDK
// (libdhd.so). The haptic loop's thread polls; each call takes the time of a USB transfer. The
// controller of these devices drops the force by itself when no command comes.
//
// Each call's result is examined by itself. Two of them are positive and no errors: nothing new,
// and saturated motors. A sum of results could hide an error behind them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "master/device/dhd/dhd_api.h"
#include "master/device/search/driver.h"

namespace palpate {

class DhdDevice final : public HapticDevice {
 public:
  struct Options {
    std::optional<int> serial;                   // nullopt: the first device
    std::vector<std::filesystem::path> folders;  // of the library, before the usual ones
  };
  // Throws DeviceUnavailable with the reason.
  static std::unique_ptr<DhdDevice> Open(const Options& options);
  ~DhdDevice() override;

  [[nodiscard]] std::string description() const override { return description_; }

 protected:
  DeviceReading DoRead(Time now) noexcept override;
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  // What is known of an open device.
  struct Opened {
    DhdApi api;
    char id = 0;
    DeviceCapabilities capabilities;
    std::string description;
    bool has_wrist = false, has_gripper = false;
  };
  explicit DhdDevice(Opened opened);
  static Opened OpenDevice(const Options& options);

  // Whether a call succeeded; if not, takes the library's words into the status.
  bool Succeeded(int code) noexcept;
  void ReadMotion(DeviceReading* reading) noexcept;
  void ReadButtons() noexcept;
  // Whether the controller has switched the force off, and why.
  void ReadForceOff() noexcept;
  void EnableForce() noexcept;

  const Opened own_;
  const std::string description_;
  const Eigen::Matrix3d R_MD_;  // frame M from the library's
  DeviceStatus status_;         // of this reading
  DeviceReading last_;
  bool enabled_ = false;       // the force was enabled
  bool was_pressed_ = false;   // the first button, at the last reading
  bool write_failed_ = false;  // the last force was not accepted
  DeviceStatus write_status_;  // why
};

// The row of the table of drivers.
Driver DhdDriver();

}  // namespace palpate
