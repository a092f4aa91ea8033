// Game controllers through SDL2: the sticks are velocity, rumble is a cue of the force. The south
// button (A, cross) or a shoulder button is the dead-man's switch.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "master/device/rate/rate_device.h"
#include "master/device/search/driver.h"

namespace palpate {

struct SdlApi {
  // Returns why it cannot be used; empty: every function is set.
  std::string Load(const LibrarySearch& search);

  int (*set_hint)(const char*, const char*) = nullptr;
  int (*init)(std::uint32_t) = nullptr;
  void (*quit)(std::uint32_t) = nullptr;
  const char* (*error)() = nullptr;
  int (*joysticks)() = nullptr;
  int (*is_controller)(int) = nullptr;
  void* (*open)(int) = nullptr;
  void (*close)(void*) = nullptr;
  const char* (*name)(void*) = nullptr;
  int (*attached)(void*) = nullptr;
  void (*update)() = nullptr;
  std::int16_t (*axis)(void*, int) = nullptr;
  std::uint8_t (*button)(void*, int) = nullptr;
  // Optional: since SDL 2.0.9.
  int (*rumble)(void*, std::uint16_t, std::uint16_t, std::uint32_t) = nullptr;
};

// When to send a rumble command: pads over Bluetooth take one in 50 ms, and some stop by
// themselves.
class RumblePace {
 public:
  static constexpr double kLeast = 0.050, kRepeat = 0.100;  // [s]
  static constexpr std::uint32_t kLasts = 200;              // of one command [ms]
  static constexpr double kDeadZone = 0.03;                 // a smaller force is not shown [-]

  // Whether to send `share` [-] now; then it is the last one sent.
  bool Send(double share, Time now);

 private:
  double last_ = 0;
  Time sent_at_{};
};

class GamepadSource final : public RateSource {
 public:
  // `folders` of the library, before the usual ones. Throws DeviceUnavailable.
  explicit GamepadSource(std::vector<std::filesystem::path> folders);
  ~GamepadSource() override;
  GamepadSource(const GamepadSource&) = delete;
  GamepadSource& operator=(const GamepadSource&) = delete;

  RateInput Poll(Time now) override;
  void Cue(double share, Time now) override;
  [[nodiscard]] std::string description() const override { return description_; }

 private:
  SdlApi api_;
  void* pad_ = nullptr;
  std::string description_;
  RumblePace pace_;
  bool gone_ = false;
};

// The row of the table of drivers.
Driver GamepadDriver();

}  // namespace palpate
