#include "master/device/gamepad/gamepad_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

constexpr std::uint32_t kGameController = 0x00002000;  // what to initialise
constexpr int kLeftX = 0, kLeftY = 1, kRightY = 3;     // axes
constexpr int kSouth = 0, kLeftShoulder = 9, kRightShoulder = 10, kButtonCount = 15;
constexpr double kFullAxis = 32767, kFullRumble = 65535;
constexpr double kStickRests = 0.15;  // sticks do not rest at zero [-]

LibrarySearch SdlSearch(std::vector<std::filesystem::path> folders) {
  return {{"libSDL2-2.0.so.0", "libSDL2.so"}, std::move(folders), false};
}

}  // namespace

std::string SdlApi::Load(const LibrarySearch& search) {
  SharedLibrary library(search);
  library.Bind("SDL_SetHint", &set_hint);
  library.Bind("SDL_InitSubSystem", &init);
  library.Bind("SDL_QuitSubSystem", &quit);
  library.Bind("SDL_GetError", &error);
  library.Bind("SDL_NumJoysticks", &joysticks);
  library.Bind("SDL_IsGameController", &is_controller);
  library.Bind("SDL_GameControllerOpen", &open);
  library.Bind("SDL_GameControllerClose", &close);
  library.Bind("SDL_GameControllerName", &name);
  library.Bind("SDL_GameControllerGetAttached", &attached);
  library.Bind("SDL_GameControllerUpdate", &update);
  library.Bind("SDL_GameControllerGetAxis", &axis);
  library.Bind("SDL_GameControllerGetButton", &button);
  library.BindOptional("SDL_GameControllerRumble", &rumble);
  return library.problem();
}

bool RumblePace::Send(double share, Time now) {
  const double shown = share < kDeadZone ? 0 : share;
  const double since = SecondsBetween(sent_at_, now);
  const bool is_due = shown != last_ ? since >= kLeast : shown > 0 && since >= kRepeat;
  if (!is_due) return false;
  last_ = shown;
  sent_at_ = now;
  return true;
}

GamepadSource::GamepadSource(std::vector<std::filesystem::path> folders) {
  const std::string problem = api_.Load(SdlSearch(std::move(folders)));
  if (!problem.empty()) throw DeviceUnavailable("gamepad", problem);
  api_.set_hint("SDL_NO_SIGNAL_HANDLERS", "1");  // the signals of the session stay ours
  api_.set_hint("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1");  // there is no window
  if (api_.init(kGameController) != 0) {
    throw DeviceUnavailable("gamepad", std::string("SDL does not start: ") + api_.error());
  }
  api_.update();
  for (int i = 0; pad_ == nullptr && i < api_.joysticks(); ++i) {
    if (api_.is_controller(i) != 0) pad_ = api_.open(i);
  }
  if (pad_ == nullptr) {
    api_.quit(kGameController);
    throw DeviceUnavailable("gamepad", "no game controller is connected that this user may read");
  }
  const char* name = api_.name(pad_);
  description_ = std::string("gamepad: ") + (name == nullptr ? "unnamed" : name) +
                 ", sticks move, A or a shoulder button engages";
}

GamepadSource::~GamepadSource() {
  if (api_.rumble != nullptr) api_.rumble(pad_, 0, 0, 0);
  api_.close(pad_);
  api_.quit(kGameController);
}

RateInput GamepadSource::Poll(Time /*now*/) {
  api_.update();
  RateInput input;
  gone_ = gone_ || api_.attached(pad_) == 0;
  if (gone_) {
    input.fault = DeviceFault::kUnplugged;
    input.cause = "the game controller is disconnected";
    return input;
  }
  const auto stick = [this](int axis) {
    const double share = std::clamp(api_.axis(pad_, axis) / kFullAxis, -1.0, 1.0);
    const double beyond = std::abs(share) - kStickRests;
    return beyond <= 0 ? 0 : std::copysign(beyond / (1 - kStickRests), share);
  };
  input.share = Eigen::Vector3d(stick(kLeftX), -stick(kLeftY), stick(kRightY));
  for (int i = 0; i < kButtonCount; ++i) {
    if (api_.button(pad_, i) != 0) input.buttons |= std::uint32_t{1} << static_cast<unsigned>(i);
  }
  constexpr std::uint32_t kSwitches = 1U << kSouth | 1U << kLeftShoulder | 1U << kRightShoulder;
  input.engaged = (input.buttons & kSwitches) != 0;
  return input;
}

void GamepadSource::Cue(double share, Time now) {
  if (gone_ || api_.rumble == nullptr || !pace_.Send(share, now)) return;
  const double shown = share < RumblePace::kDeadZone ? 0 : share;
  const auto strength = static_cast<std::uint16_t>(std::lround(kFullRumble * shown));
  api_.rumble(pad_, strength, strength, shown > 0 ? RumblePace::kLasts : 0);
}

Driver GamepadDriver() {
  return {"gamepad", "game controllers (SDL2); rumble is a cue of the force",
          "speed in mm/s, 20 by default",
          [] {
            DriverReport report;
            const LibrarySearch search = SdlSearch({});
            AddLibrary(search, SharedLibrary(search), &report);
            if (!report.missing.empty()) {
              report.next = "sudo apt-get install libsdl2-2.0-0";
              return report;
            }
            AddOpened(GamepadDriver(), &report);
            if (!report.usable) {
              report.next =
                  "connect a game controller; its /dev/input/event* must be readable: "
                  "sudo usermod -aG input $USER, then log in again";
            }
            return report;
          },
          [](const std::string& option) -> std::unique_ptr<HapticDevice> {
            const double speed = SpeedOf("gamepad", option);
            return std::make_unique<RateDevice>(
                std::make_unique<GamepadSource>(std::vector<std::filesystem::path>()), speed);
          }};
}

}  // namespace palpate
