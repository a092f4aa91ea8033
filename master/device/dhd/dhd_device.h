// Force Dimension omega, delta, sigma, lambda and the Novint Falcon through the Force Dimension SDK
// (libdhd.so). Each call takes the time of a USB transfer. Therefore a thread of ours reads the
// device, runs the tick of the haptic loop and writes the force, as the vendor's thread of other
// devices does. The tick itself never waits: while a transfer hangs, the loop's own thread ticks,
// and disengages. The controller of these devices drops the force by itself when no command comes.
//
// Each call's result is checked separately, because two positive results are no errors: no new
// data, and saturated motors.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "master/device/dhd/dhd_api.h"
#include "master/device/search/driver.h"
#include "shared/link/latest_value.h"

namespace palpate {

class DhdDevice final : public HapticDevice {
 public:
  struct Options {
    std::optional<int> serial;                   // nullopt: the first device
    std::vector<std::filesystem::path> folders;  // of the library, before the usual ones
    bool own_thread = true;                      // false: the caller's thread waits for transfers
  };
  // Throws DeviceUnavailable with the reason.
  static std::unique_ptr<DhdDevice> Open(const Options& options);
  ~DhdDevice() override;

  [[nodiscard]] std::string description() const override { return description_; }
  bool StartTicks(const Tick* tick) override;
  void StopTicks() override;

 protected:
  // If the own thread runs the ticks, DoRead and DoWrite exchange the newest values with it.
  DeviceReading DoRead(Time now) noexcept override;
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  // Opened holds the properties that are read once from an open device.
  struct Opened {
    DhdApi api;
    char id = 0;
    DeviceCapabilities capabilities;
    std::string description;
    bool has_wrist = false, has_gripper = false;
  };
  // A force, and when it was written.
  struct Command {
    Wrench wrench;
    Time at{};
  };
  DhdDevice(Opened opened, bool own_thread);
  static Opened OpenDevice(const Options& options);

  void RunTicks(const Tick& tick, const std::stop_token& stop) noexcept;
  // Measure and the function below wait for transfers.
  [[nodiscard]] DeviceReading Measure(Time now) noexcept;
  DeviceOutput Send(const Wrench& wrench) noexcept;
  // Returns whether a call succeeded; if not, copies the library's message to the status.
  bool Succeeded(int code) noexcept;
  void ReadMotion(DeviceReading* reading) noexcept;
  void ReadButtons() noexcept;
  // Compares the force that the device renders with the last one that it accepted.
  void ReadForceShare() noexcept;
  // Whether the controller has switched the force off, and why.
  void ReadForceOff() noexcept;
  void EnableForce() noexcept;

  const Opened own_;
  const std::string description_;
  const Eigen::Matrix3d R_MD_;  // frame M from the library's
  const bool may_thread_;
  bool threaded_ = false;                                 // the own thread runs the ticks
  LatestValue<DeviceReading> frames_;                     // from the own thread
  LatestValue<Command> commands_;                         // to the own thread
  std::atomic<DeviceOutput> output_{DeviceOutput::kOff};  // of the newest command
  DeviceReading newest_;                                  // of `frames_`
  Time read_at_{};

  // The state of the own thread while it runs.
  DeviceStatus status_;  // of this reading
  DeviceReading last_;
  bool enabled_ = false;           // the force was enabled
  bool was_pressed_ = false;       // the first button, at the last reading
  bool write_failed_ = false;      // the last force was not accepted
  Eigen::Vector3d sent_{0, 0, 0};  // the last force, frame of the library [N]
  DeviceStatus write_status_;      // why
  std::jthread thread_;            // last: it uses the rest
};

// The row of the table of drivers.
Driver DhdDriver();

}  // namespace palpate
