// Game controllers through SDL2: the sticks are velocity, rumble is a cue of the force. The south
// button (A, cross) or a shoulder button is the dead-man's switch. Part of palpate-devices.so.
#pragma once

#include <string>

#include "master/device/rate/rate_device.h"
#include "master/device/rate/rumble_pace.h"

struct _SDL_GameController;

namespace palpate {

class GamepadSource final : public RateSource {
 public:
  // Throws DeviceUnavailable.
  GamepadSource();
  ~GamepadSource() override;
  GamepadSource(const GamepadSource&) = delete;
  GamepadSource& operator=(const GamepadSource&) = delete;

  RateInput Poll(Time now) override;
  void Cue(double share, Time now) override;
  [[nodiscard]] std::string description() const override { return description_; }

 private:
  _SDL_GameController* pad_ = nullptr;
  std::string description_;
  RumblePace pace_;
  bool gone_ = false;
};

}  // namespace palpate
