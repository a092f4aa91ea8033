// A stand-in for SDL 2.26 with at most one game controller. What it reports changes with
// SDL_GameControllerUpdate.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/master/device/fakes/fake_core.h"

namespace palpate::fakes {

struct GameController {
  int instance;
  bool attached;
};

namespace {

using Guard = std::lock_guard<std::recursive_mutex>;

constexpr std::uint32_t kJoystick = 0x200, kGameController = 0x2000;
constexpr double kFullWay = 0.010;  // of a stick [m]

struct Sdl : Core {
  std::uint32_t initialised = 0;
  int instance = -1, next_instance = 0;  // -1: no joystick that SDL knows of
  Sample pumped;
  GameController* opened = nullptr;
  std::string error;
  double low = 0, high = 0, rumbles_until = 0, taken_at = -1;

  ~Sdl() override { delete opened; }

  // drift_x, drift_y: counts of a stick at rest.
  std::map<std::string, std::string> Defaults() const override {
    return {{"drift_x", "512"}, {"drift_y", "-300"}};
  }
  void OnReset() override {
    const Guard guard(mutex);
    initialised = 0;
    instance = -1;
    next_instance = 0;
    pumped = {};
    delete opened;
    opened = nullptr;
    error.clear();
    low = high = rumbles_until = 0;
    taken_at = -1;
  }
  void OnPlug() override { low = high = 0; }

  bool MotorsOn() const override { return time < rumbles_until && (low > 0 || high > 0); }
  Eigen::Vector3d MotorForce() const override {
    return time < rumbles_until ? Eigen::Vector3d(low, high, 0)
                                : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }

  int Fail(const std::string& what) {
    error = what;
    return -1;
  }
  bool Has(std::uint32_t subsystem) const { return initialised & subsystem; }
  void Pump() {
    Sync();
    if (!Has(kJoystick | kGameController)) return;
    if (plugged && instance < 0) {
      instance = next_instance++;
    } else if (!plugged && instance >= 0) {
      if (opened) opened->attached = false;
      instance = -1;
    }
    pumped = plugged ? Look() : Sample{};
  }
  // Over Bluetooth a command takes 50 ms, and others meanwhile are lost.
  int Rumble(double low_part, double high_part, std::uint32_t ms) {
    if (!plugged) return Fail("That operation is not supported");
    if (frozen) return 0;
    if (taken_at >= 0 && time - taken_at < 0.050 - 1e-9) return 0;
    taken_at = time;
    low = low_part;
    high = high_part;
    rumbles_until = time + std::min(1e-3 * ms, 65.535);
    return 0;
  }
};

Sdl sdl;

}  // namespace

Core& TheCore() {
  return sdl;
}

namespace {
const Start start(sdl, "SDL");
}

FAKE_EXPORT int SDL_InitSubSystem(std::uint32_t flags) {
  const Guard guard(sdl.mutex);
  if (sdl.Enter(__func__)) return sdl.Fail("no such subsystem");
  if (flags & kGameController) flags |= kJoystick;
  sdl.initialised |= flags;
  sdl.Pump();
  return 0;
}

FAKE_EXPORT void SDL_QuitSubSystem(std::uint32_t flags) {
  const Guard guard(sdl.mutex);
  sdl.initialised &= ~flags;
  if (!sdl.Has(kJoystick)) sdl.instance = -1;
}

FAKE_EXPORT int SDL_SetHint(const char*, const char*) {
  return 1;
}
FAKE_EXPORT const char* SDL_GetError() {
  return sdl.error.c_str();
}
FAKE_EXPORT void SDL_GameControllerUpdate() {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  sdl.Pump();
}

FAKE_EXPORT int SDL_NumJoysticks() {
  const Guard guard(sdl.mutex);
  if (const int code = sdl.Enter(__func__)) return code;
  return sdl.instance >= 0;
}

FAKE_EXPORT int SDL_IsGameController(int index) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  return index == 0 && sdl.instance >= 0;
}

// A second opening gives the same controller.
FAKE_EXPORT GameController* SDL_GameControllerOpen(int index) {
  const Guard guard(sdl.mutex);
  if (sdl.Enter(__func__) || !SDL_IsGameController(index)) {
    sdl.Fail("Couldn't find a controller");
    return nullptr;
  }
  if (sdl.opened && sdl.opened->attached) return sdl.opened;
  delete sdl.opened;
  return sdl.opened = new GameController{sdl.instance, true};
}

FAKE_EXPORT void SDL_GameControllerClose(GameController* pad) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  if (!pad || pad != sdl.opened) return;
  delete sdl.opened;
  sdl.opened = nullptr;
  sdl.low = sdl.high = 0;
}

FAKE_EXPORT int SDL_GameControllerGetAttached(GameController* pad) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  return pad && pad == sdl.opened && pad->attached;
}

FAKE_EXPORT const char* SDL_GameControllerName(GameController* pad) {
  return pad && pad->attached ? "Xbox Wireless Controller" : nullptr;
}

// A controller that is gone reads as one at rest.
FAKE_EXPORT std::int16_t SDL_GameControllerGetAxis(GameController* pad, int axis) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  if (!pad || pad != sdl.opened || !pad->attached || axis < 0 || axis > 5) return 0;
  const Eigen::Vector3d part = 32767 / kFullWay * sdl.pumped.p;
  double counts = 0;
  switch (axis) {
    case 0:
      counts = part.x() + sdl.Number("drift_x");
      break;
    case 1:
      counts = -part.y() + sdl.Number("drift_y");
      break;  // down is positive
    case 3:
      counts = -part.z();
      break;
    default:
      break;
  }
  return static_cast<std::int16_t>(std::clamp(std::round(counts), -32768.0, 32767.0));
}

FAKE_EXPORT unsigned char SDL_GameControllerGetButton(GameController* pad, int button) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  if (!pad || pad != sdl.opened || !pad->attached || button < 0 || button > 20) return 0;
  return sdl.pumped.buttons >> button & 1;
}

FAKE_EXPORT int SDL_GameControllerRumble(GameController* pad, std::uint16_t low, std::uint16_t high,
                                         std::uint32_t ms) {
  const Guard guard(sdl.mutex);
  if (sdl.Enter(__func__)) return sdl.Fail("rumble failed");
  if (!pad || pad != sdl.opened || !pad->attached)
    return sdl.Fail("Parameter 'gamecontroller' is invalid");
  return sdl.Rumble(low / 65535.0, high / 65535.0, ms);
}

}  // namespace palpate::fakes
