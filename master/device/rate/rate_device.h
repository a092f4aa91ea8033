// Devices that command a velocity and have no force: SpaceMouse, gamepad. The intent
// moves at the commanded velocity, and the device follows it through the arm model, so that it lags
// behind under force. A source is polled on a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "master/device/arm.h"
#include "master/device/haptic_device.h"
#include "shared/link/latest_value.h"

namespace palpate {

// RateInput is the command of a source.
struct RateInput {
  Eigen::Vector3d share{0, 0, 0};  // of the largest speed, frame M [-], each within -1..1
  bool engaged = false;            // the dead-man's switch is closed
  std::uint32_t buttons = 0;
  DeviceFault fault = DeviceFault::kNone;
  const char* cause = "";  // of the fault, of static lifetime
  Time received_at{};      // set by RateDevice
};

class RateSource {
 public:
  virtual ~RateSource() = default;
  // The present input. Called every 5 ms by one thread; may allocate, but not wait.
  virtual RateInput Poll(Time now) = 0;
  // Shows the operator a force, as a share of the largest [-]. Called after each Poll.
  virtual void Cue(double /*share*/, Time /*now*/) {}
  [[nodiscard]] virtual std::string description() const = 0;
};

class RateDevice final : public HapticDevice {
 public:
  // Age of the input above which the device stops, and above which it has a fault [s].
  static constexpr double kStopAfter = 0.020, kSilentAfter = 0.100;

  // `speed` > 0: at full deflection [m/s]. With `polls` a thread polls the source; without, the
  // caller does. Throws std::invalid_argument for another speed.
  RateDevice(std::unique_ptr<RateSource> source, double speed, bool polls = true);

  // Polls the source once.
  void Poll(Time now);
  [[nodiscard]] std::string description() const override { return description_; }

 protected:
  DeviceReading DoRead(Time now) noexcept override;
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  const std::unique_ptr<RateSource> source_;
  const double speed_;  // [m/s]
  const std::string description_;
  LatestValue<RateInput> inputs_;
  std::atomic<double> force_share_{0};    // force as a share of the largest [-]
  std::atomic<Time> written_at_{Time{}};  // when it was written
  RateInput input_;                       // the newest
  HandIntent intent_;
  MovingArm hand_;
  std::optional<Time> last_;
  std::jthread thread_;  // last: it uses the rest
};

// The speed that the text after the colon gives in mm/s, or 20 mm/s; in m/s. Throws
// std::invalid_argument that names `device`.
double SpeedOf(const std::string& device, const std::string& option);

}  // namespace palpate
