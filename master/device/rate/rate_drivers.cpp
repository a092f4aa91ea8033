#include "master/device/rate/rate_drivers.h"

#include "master/device/rate/rate_device.h"
#include "shared/program/program.h"

namespace palpate {
namespace {

constexpr const char* kModule = "palpate-devices.so";
constexpr const char* kNoModule =
    "palpate-devices.so is not installed next to this program. Install the package "
    "palpate-devices, or run deploy/install.sh devices and deploy/build.sh release";

// The device that `function` of the module opens. Throws DeviceUnavailable.
std::unique_ptr<RateSource> OpenSource(const std::string& device, const char* function) {
  const auto file = FindPart(kModule);
  if (file.empty()) throw DeviceUnavailable(device, kNoModule);
  SharedLibrary module({{file.string()}, {}, false});
  RateSource* (*open)(std::string*) = nullptr;
  module.Bind(function, &open);
  std::string problem = module.problem();
  std::unique_ptr<RateSource> source(problem.empty() ? open(&problem) : nullptr);
  if (!source) throw DeviceUnavailable(device, problem);
  return source;
}

std::unique_ptr<HapticDevice> OpenRateDevice(const std::string& device, const std::string& option,
                                             const char* function) {
  const double speed = SpeedOf(device, option);
  return std::make_unique<RateDevice>(OpenSource(device, function), speed);
}

// `next`: advice if the module is installed, but no device is found.
DriverReport Examined(const Driver& driver, const char* next) {
  DriverReport report;
  const auto file = FindPart(kModule);
  report.searched.emplace_back(kModule);
  if (!file.empty()) report.found.push_back(file.string());
  if (!file.empty()) report.next = next;
  AddOpened(driver, &report);
  if (report.usable) report.next.clear();
  return report;
}

}  // namespace

Driver SpaceMouseDriver() {
  return {"spacemouse", "3Dconnexion SpaceMouse (libspnav, spacenavd), without force",
          "speed in mm/s, 20 by default",
          [] {
            return Examined(SpaceMouseDriver(),
                            "sudo apt-get install spacenavd; sudo systemctl start spacenavd");
          },
          [](const std::string& option) {
            return OpenRateDevice("spacemouse", option, "palpate_open_spacemouse");
          }};
}

Driver GamepadDriver() {
  return {"gamepad", "game controllers (SDL2); rumble is a cue of the force",
          "speed in mm/s, 20 by default",
          [] {
            return Examined(GamepadDriver(),
                            "connect a game controller; its /dev/input/event* must be readable: "
                            "sudo usermod -aG input $USER, then log in again");
          },
          [](const std::string& option) {
            return OpenRateDevice("gamepad", option, "palpate_open_gamepad");
          }};
}

}  // namespace palpate
