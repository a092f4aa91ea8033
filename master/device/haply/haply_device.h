// Haply Inverse3 with a VerseGrip, through the vendor's service on this machine. The service
// answers each force with one state, on a thread of ours; the haptic loop exchanges the newest
// values with it. When that thread sends nothing, the service makes the device idle.
//
// The service scales forces, and adds those of other programs. Therefore the force that it reports
// is compared with the force that was sent, and the share is shown.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "master/device/haply/haply_line.h"
#include "master/device/haply/haply_message.h"
#include "master/device/search/driver.h"
#include "shared/link/latest_value.h"

namespace palpate {

class HaplyDevice final : public HapticDevice {
 public:
  static constexpr std::uint16_t kPort = 10001;

  struct Options {
    std::uint16_t port = kPort;
    std::function<Time()> clock = [] { return Clock::now(); };
  };
  // Throws DeviceUnavailable with the reason.
  static std::unique_ptr<HaplyDevice> Open(const Options& options);
  ~HaplyDevice() override;

  [[nodiscard]] std::string description() const override { return description_; }

 protected:
  DeviceReading DoRead(Time now) noexcept override;
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  // A force, and when it was written.
  struct Command {
    Eigen::Vector3d force{0, 0, 0};  // M [N]
    Time at{};
  };
  // Opened holds what the service reports when the device opens.
  struct Opened {
    std::unique_ptr<HaplyLine> line;
    HaplyForm form = HaplyForm::kVector;
    HaplyState first;
    std::string description;
  };
  HaplyDevice(Opened opened, const Options& options);
  static Opened OpenLine(const Options& options);

  // The thread: exchanges forces and states, and connects again after a loss.
  void Work(const std::stop_token& stop);
  // Sends one force and receives one state. Returns false if the connection is lost.
  bool Exchange(const std::stop_token& stop);
  void Publish(const HaplyState& state);
  void PublishFault(const char* cause);
  // Returns the rendered force divided by the sent force [-]; NaN for forces that are too small.
  [[nodiscard]] float ForceShare(const HaplyState& state) const;

  const std::unique_ptr<HaplyLine> line_;
  const HaplyForm form_;
  const std::string description_;
  const std::function<Time()> clock_;
  LatestValue<DeviceReading> readings_;  // from the thread
  LatestValue<Command> commands_;        // to the thread
  DeviceReading newest_;                 // of `readings_`
  Time read_at_{};

  // The state of the thread.
  std::string id_;
  Command command_;
  Eigen::Vector3d sent_{0, 0, 0};  // M, with the last message [N]
  DeviceReading last_;             // for velocities that the service does not report
  std::jthread thread_;            // last: it uses the rest
};

// The row of the table of drivers.
Driver HaplyDriver();

}  // namespace palpate
