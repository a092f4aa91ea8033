// 3D Systems Touch, Touch X, Omni, Desktop and Premium through OpenHaptics (libHD.so). The vendor's
// servo thread calls us: it runs the ticks of the haptic loop, and drops the force by itself when
// no tick writes one for 20 ms.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "master/device/search/driver.h"
#include "master/device/touch/hd_api.h"
#include "shared/link/latest_value.h"

namespace palpate {

class TouchDevice final : public HapticDevice {
 public:
  struct Options {
    std::string name;  // as in the vendor's configuration; empty: the usual names are tried
    std::vector<std::filesystem::path> folders;  // of the library, before the usual ones
    std::function<Time()> clock = [] { return Clock::now(); };
  };
  // Throws DeviceUnavailable with the reason.
  static std::unique_ptr<TouchDevice> Open(const Options& options);
  ~TouchDevice() override;

  [[nodiscard]] std::string description() const override { return description_; }
  bool StartTicks(const Tick* tick) override;
  void StopTicks() override;

 protected:
  // The newest frame of the servo thread.
  DeviceReading DoRead(Time now) noexcept override;
  // Leaves the force for the servo thread.
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  // Opened holds the properties that are read once from an open device.
  struct Opened {
    HdApi api;
    unsigned handle = 0;
    DeviceCapabilities capabilities;
    std::string description;
  };
  // A force, and when it was written.
  struct Command {
    Eigen::Vector3d force{0, 0, 0};  // M [N]
    Time at{};
  };

  TouchDevice(Opened opened, std::function<Time()> clock);
  static Opened OpenDevice(const Options& options);
  static std::string DescribeOpened(const HdApi& api);

  // Runs one frame on the servo thread.
  void ServoFrame() noexcept;
  [[nodiscard]] DeviceReading Measure(Time now) noexcept;
  void Calibrate() noexcept;
  // Reads the errors since the last call; the first one becomes the fault. Returns whether the
  // force was limited.
  bool CollectErrors() noexcept;
  void SendForce(Time now) noexcept;

  const HdApi api_;
  const unsigned handle_;
  const std::string description_;
  const std::function<Time()> clock_;
  unsigned long task_ = 0;
  LatestValue<DeviceReading> frames_;  // from the servo thread
  LatestValue<Command> commands_;      // to the servo thread
  // Time of the newest reading, which is also the time of a new command.
  std::atomic<Time> read_at_{Time{}};
  std::atomic<const Tick*> tick_{nullptr};
  std::atomic<bool> inside_{false};  // the servo thread is inside a tick
  std::atomic<bool> saturated_{false};
  DeviceReading newest_;  // of `frames_`

  // The state of the servo thread.
  Command command_;
  DeviceStatus status_;
  std::uint64_t frame_ = 0;
  bool enabled_ = false;          // force output
  bool has_temperature_ = false;  // the model and the release report it
};

// The row of the table of drivers.
Driver TouchDriver();

}  // namespace palpate
