// A stand-in for SDL 2.26 with at most one game controller. What it reports changes when events are
// pumped.
//
// Compiled with FAKE_MISSING it lacks SDL_GameControllerGetAttached; with FAKE_OLD it is
// version 2.0.5, which has no rumble.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>

#include "tests/master/device/fakes/fake_core.h"

namespace palpate::fakes {

struct Event {
  std::uint32_t type, time;
  std::int32_t which;
  unsigned char rest[44];
};
static_assert(sizeof(Event) == 56);

struct GameController {
  int instance;
  bool attached;
};

namespace {

using Guard = std::lock_guard<std::recursive_mutex>;

constexpr std::uint32_t kJoystick = 0x200, kGameController = 0x2000, kEvents = 0x4000;
constexpr std::uint32_t kJoystickAdded = 0x605, kJoystickRemoved = 0x606, kControllerAdded = 0x653,
                        kControllerRemoved = 0x654;
constexpr double kFullWay = 0.010;  // of a stick [m]

struct Sdl : Core {
  std::uint32_t initialised = 0;
  int instance = -1, next_instance = 0;  // -1: no joystick that SDL knows of
  Sample pumped;
  GameController* opened = nullptr;
  std::string error;
  std::deque<Event> events;
  double low = 0, high = 0, rumbles_until = 0, taken_at = -1;

  ~Sdl() override { delete opened; }

  // pad: xbox, which over Bluetooth takes a command in 50 ms and loses others; ds4, which stops
  // after 5 s; pulse, which stops after 50 ms; wired. rumble: 0 has none. controller: 0 is a
  // joystick without a mapping. drift_x, drift_y: counts of a stick at rest. axis2, axis4, axis5:
  // right stick to the right, left and right trigger [counts].
  std::map<std::string, std::string> Defaults() const override {
    return {{"pad", "xbox"},     {"rumble", "1"},          {"controller", "1"}, {"drift_x", "512"},
            {"drift_y", "-300"}, {"axis2", "0"},           {"axis4", "0"},      {"axis5", "0"},
            {"mass", "0.02"},    {"viscosity", "5"},       {"half_x", "0.01"},  {"half_y", "0.01"},
            {"half_z", "0.01"},  {"grip_stiffness", "inf"}};
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
    events.clear();
    low = high = rumbles_until = 0;
    taken_at = -1;
  }
  Eigen::Vector3d Weight() const override { return -500 * p; }
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
  void Tell(std::uint32_t type, int which) {
    events.push_back({type, static_cast<std::uint32_t>(1000 * time), which, {}});
  }
  void Pump() {
    Sync();
    if (!Has(kJoystick | kGameController)) return;
    if (plugged && instance < 0) {
      instance = next_instance++;
      Tell(kJoystickAdded, 0);
      if (Number("controller") != 0) Tell(kControllerAdded, 0);
    } else if (!plugged && instance >= 0) {
      Tell(kJoystickRemoved, instance);
      if (Number("controller") != 0) Tell(kControllerRemoved, instance);
      if (opened) opened->attached = false;
      instance = -1;
    }
    pumped = plugged ? Look() : Sample{};
  }
  int Rumble(double low_part, double high_part, std::uint32_t ms) {
    const std::string& pad = Text("pad");
    if (!plugged || Number("rumble") == 0) return Fail("That operation is not supported");
    if (frozen) return 0;
    Log({low_part, high_part, 0, 0, 0, 0, 0});
    if (pad == "xbox" && taken_at >= 0 && time - taken_at < 0.050 - 1e-9) return 0;
    taken_at = time;
    low = low_part;
    high = high_part;
    const double most = pad == "ds4" ? 5 : pad == "pulse" ? 0.050 : 65.535;
    rumbles_until = time + std::min(1e-3 * ms, most);
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
  if (flags & kJoystick) flags |= kEvents;
  sdl.initialised |= flags;
  sdl.Pump();
  return 0;
}

FAKE_EXPORT int SDL_Init(std::uint32_t flags) {
  return SDL_InitSubSystem(flags);
}

FAKE_EXPORT void SDL_QuitSubSystem(std::uint32_t flags) {
  const Guard guard(sdl.mutex);
  sdl.initialised &= ~flags;
  if (!sdl.Has(kJoystick)) sdl.instance = -1;
}

FAKE_EXPORT void SDL_Quit() {
  SDL_QuitSubSystem(0xFFFFFFFF);
}

FAKE_EXPORT std::uint32_t SDL_WasInit(std::uint32_t flags) {
  const Guard guard(sdl.mutex);
  return flags ? sdl.initialised & flags : sdl.initialised;
}

FAKE_EXPORT int SDL_SetHint(const char*, const char*) {
  return 1;
}
FAKE_EXPORT void SDL_SetMainReady() {}
FAKE_EXPORT const char* SDL_GetError() {
  return sdl.error.c_str();
}
FAKE_EXPORT void SDL_ClearError() {
  sdl.error.clear();
}

FAKE_EXPORT void SDL_GetVersion(unsigned char version[3]) {
#ifdef FAKE_OLD
  const unsigned char is[3] = {2, 0, 5};
#else
  const unsigned char is[3] = {2, 26, 5};
#endif
  std::copy(is, is + 3, version);
}

FAKE_EXPORT std::uint32_t SDL_GetTicks() {
  const Guard guard(sdl.mutex);
  return static_cast<std::uint32_t>(1000 * sdl.Sync());
}

FAKE_EXPORT void SDL_PumpEvents() {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  sdl.Pump();
}

FAKE_EXPORT void SDL_JoystickUpdate() {
  SDL_PumpEvents();
}
FAKE_EXPORT void SDL_GameControllerUpdate() {
  SDL_PumpEvents();
}

FAKE_EXPORT int SDL_PollEvent(Event* event) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  sdl.Pump();
  if (sdl.events.empty()) return 0;
  if (!event) return 1;
  *event = sdl.events.front();
  sdl.events.pop_front();
  return 1;
}

FAKE_EXPORT void SDL_FlushEvents(std::uint32_t from, std::uint32_t to) {
  const Guard guard(sdl.mutex);
  std::erase_if(sdl.events,
                [=](const Event& event) { return event.type >= from && event.type <= to; });
}

FAKE_EXPORT int SDL_NumJoysticks() {
  const Guard guard(sdl.mutex);
  if (const int code = sdl.Enter(__func__)) return code;
  return sdl.instance >= 0;
}

FAKE_EXPORT int SDL_IsGameController(int index) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  return index == 0 && sdl.instance >= 0 && sdl.Number("controller") != 0;
}

FAKE_EXPORT const char* SDL_JoystickNameForIndex(int index) {
  const Guard guard(sdl.mutex);
  if (index != 0 || sdl.instance < 0) return sdl.Fail("There are 0 joysticks available"), nullptr;
  return sdl.Text("pad") == "ds4" ? "PS4 Controller" : "Xbox Wireless Controller";
}

FAKE_EXPORT const char* SDL_GameControllerNameForIndex(int index) {
  return SDL_IsGameController(index) ? SDL_JoystickNameForIndex(index) : nullptr;
}

FAKE_EXPORT int SDL_JoystickGetDeviceInstanceID(int index) {
  const Guard guard(sdl.mutex);
  return index == 0 ? sdl.instance : -1;
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

#ifndef FAKE_MISSING
FAKE_EXPORT int SDL_GameControllerGetAttached(GameController* pad) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  return pad && pad == sdl.opened && pad->attached;
}
#endif

FAKE_EXPORT const char* SDL_GameControllerName(GameController* pad) {
  return pad && pad->attached ? SDL_JoystickNameForIndex(0) : nullptr;
}

FAKE_EXPORT void* SDL_GameControllerGetJoystick(GameController* pad) {
  return pad;
}
FAKE_EXPORT int SDL_JoystickInstanceID(void* joystick) {
  return joystick ? static_cast<GameController*>(joystick)->instance : -1;
}
FAKE_EXPORT int SDL_JoystickIsHaptic(void*) {
  return 0;
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
      counts = sdl.Number("axis" + std::to_string(axis));
  }
  return static_cast<std::int16_t>(std::clamp(std::round(counts), -32768.0, 32767.0));
}

FAKE_EXPORT unsigned char SDL_GameControllerGetButton(GameController* pad, int button) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  if (!pad || pad != sdl.opened || !pad->attached || button < 0 || button > 20) return 0;
  return sdl.pumped.buttons >> button & 1;
}

#ifndef FAKE_OLD
FAKE_EXPORT int SDL_GameControllerHasRumble(GameController* pad) {
  const Guard guard(sdl.mutex);
  sdl.Enter(__func__);
  return pad && pad == sdl.opened && pad->attached && sdl.Number("rumble") != 0;
}

FAKE_EXPORT int SDL_GameControllerRumble(GameController* pad, std::uint16_t low, std::uint16_t high,
                                         std::uint32_t ms) {
  const Guard guard(sdl.mutex);
  if (sdl.Enter(__func__)) return sdl.Fail("rumble failed");
  if (!pad || pad != sdl.opened || !pad->attached)
    return sdl.Fail("Parameter 'gamecontroller' is invalid");
  return sdl.Rumble(low / 65535.0, high / 65535.0, ms);
}
#endif

}  // namespace palpate::fakes
