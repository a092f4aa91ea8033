#include "master/device/gamepad/gamepad_source.h"

#include <algorithm>
#include <cmath>

#include <SDL.h>

#include "master/device/search/driver.h"

namespace palpate {
namespace {

constexpr double kFullAxis = 32767, kFullRumble = 65535;
constexpr double kStickRests = 0.15;  // sticks do not rest at zero [-]

}  // namespace

GamepadSource::GamepadSource() {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");  // the session handles signals itself
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");  // there is no window
  if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0) {
    throw DeviceUnavailable("gamepad", std::string("SDL does not start: ") + SDL_GetError());
  }
  SDL_GameControllerUpdate();
  for (int i = 0; pad_ == nullptr && i < SDL_NumJoysticks(); ++i) {
    if (SDL_IsGameController(i) == SDL_TRUE) pad_ = SDL_GameControllerOpen(i);
  }
  if (pad_ == nullptr) {
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
    throw DeviceUnavailable("gamepad", "no game controller is connected that this user may read");
  }
  const char* name = SDL_GameControllerName(pad_);
  description_ = std::string("gamepad: ") + (name == nullptr ? "unnamed" : name) +
                 ", sticks move, A or a shoulder button engages";
}

GamepadSource::~GamepadSource() {
  SDL_GameControllerRumble(pad_, 0, 0, 0);
  SDL_GameControllerClose(pad_);
  SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
}

RateInput GamepadSource::Poll(Time /*now*/) {
  SDL_GameControllerUpdate();
  RateInput input;
  gone_ = gone_ || SDL_GameControllerGetAttached(pad_) == SDL_FALSE;
  if (gone_) {
    input.fault = DeviceFault::kUnplugged;
    input.cause = "the game controller is disconnected";
    return input;
  }
  const auto stick = [this](SDL_GameControllerAxis axis) {
    const double share = std::clamp(SDL_GameControllerGetAxis(pad_, axis) / kFullAxis, -1.0, 1.0);
    const double beyond = std::abs(share) - kStickRests;
    return beyond <= 0 ? 0 : std::copysign(beyond / (1 - kStickRests), share);
  };
  input.share = Eigen::Vector3d(stick(SDL_CONTROLLER_AXIS_LEFTX), -stick(SDL_CONTROLLER_AXIS_LEFTY),
                                stick(SDL_CONTROLLER_AXIS_RIGHTY));
  for (int i = 0; i <= SDL_CONTROLLER_BUTTON_DPAD_RIGHT; ++i) {
    const auto button = static_cast<SDL_GameControllerButton>(i);
    if (SDL_GameControllerGetButton(pad_, button) != 0) input.buttons |= 1U << i;
  }
  constexpr std::uint32_t kSwitches = 1U << SDL_CONTROLLER_BUTTON_A |
                                      1U << SDL_CONTROLLER_BUTTON_LEFTSHOULDER |
                                      1U << SDL_CONTROLLER_BUTTON_RIGHTSHOULDER;
  input.engaged = (input.buttons & kSwitches) != 0;
  return input;
}

void GamepadSource::Cue(double share, Time now) {
  if (gone_ || !pace_.Send(share, now)) return;
  const double shown = share < RumblePace::kDeadZone ? 0 : share;
  const auto strength = static_cast<std::uint16_t>(std::lround(kFullRumble * shown));
  SDL_GameControllerRumble(pad_, strength, strength, shown > 0 ? RumblePace::kLasts : 0);
}

}  // namespace palpate
