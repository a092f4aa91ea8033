// 3Dconnexion SpaceMouse through libspnav and its daemon spacenavd: deflection of the cap is a
// velocity. It has no force. The intent moves at the commanded velocity, and the device follows it
// through the arm model, so that it lags behind under force. The first button that is ever pressed
// is the dead-man's switch, since the numbers of buttons have holes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "master/device/arm.h"
#include "master/device/haptic_device.h"
#include "master/device/search/driver.h"
#include "shared/link/latest_value.h"

namespace palpate {

// An event of libspnav, declared here in our own words.
union SpnavEvent {
  static constexpr int kMotion = 1, kButton = 2, kDevice = 3;
  static constexpr int kRemoved = 1;
  int type;
  struct {
    int type, x, y, z, rx, ry, rz;
    unsigned period;
    int* data;
  } motion;
  struct {
    int type, press, number;
  } button;
  struct {
    int type, change, id, kind, usb[2];
  } device;
};

// The part of libspnav.so that the driver calls.
struct SpnavApi {
  // Returns why it cannot be used; empty: every function is set.
  std::string Load();

  int (*open)() = nullptr;
  int (*close)() = nullptr;
  int (*descriptor)() = nullptr;
  int (*poll_event)(SpnavEvent*) = nullptr;
  int (*device_name)(char*, int) = nullptr;  // optional: releases before 1.0 lack it
};

class SpaceMouse final : public HapticDevice {
 public:
  // Age of the input above which the device stops, and above which it has a fault [s].
  static constexpr double kStopAfter = 0.020, kSilentAfter = 0.100;

  // `speed` > 0: at full deflection [m/s]. With `polls` a thread polls the daemon; without, the
  // caller does. Throws DeviceUnavailable, or std::invalid_argument for another speed.
  explicit SpaceMouse(double speed, bool polls = true);
  ~SpaceMouse() override;
  SpaceMouse(const SpaceMouse&) = delete;
  SpaceMouse& operator=(const SpaceMouse&) = delete;

  // Takes the daemon's events. Does not wait.
  void Poll(Time now);
  [[nodiscard]] std::string description() const override { return description_; }

 protected:
  DeviceReading DoRead(Time now) noexcept override;
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  struct Input {
    Eigen::Vector3d share{0, 0, 0};  // of the largest speed, frame M [-], each within -1..1
    std::uint32_t buttons = 0;
    const char* lost = nullptr;  // why the device is lost, of static lifetime
    Time received_at{};
  };
  void TakeEvent(const SpnavEvent& event, Time now);

  SpnavApi api_;
  const double speed_;  // [m/s]
  std::string description_;
  // Used by Poll.
  Eigen::Vector3d counts_{0, 0, 0};  // frame M
  double full_scale_ = 350;          // counts at full deflection; grows with what was seen
  std::vector<int> known_buttons_;   // numbers, in the order of their first press
  std::uint32_t buttons_ = 0;        // bit: place in known_buttons_
  Time moved_at_{};                  // of the last motion
  bool closed_ = false, unplugged_ = false;

  LatestValue<Input> inputs_;
  // Used by the haptic loop.
  Input input_;  // the newest
  HandIntent intent_;
  MovingArm hand_;
  std::optional<Time> last_;
  std::jthread thread_;  // last: it uses the rest
};

// Row of the table of drivers.
Driver SpaceMouseDriver();

}  // namespace palpate
