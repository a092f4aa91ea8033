#include <stdexcept>

#include "master/device/device.h"
#include "master/device/playback.h"
#include "master/device/registry/drivers.h"
#include "master/device/sim_hand.h"

namespace palpate {
namespace {

constexpr std::string_view kPlayback = "playback:";

}  // namespace

std::filesystem::path PlaybackFile(const std::string& spec) {
  return spec.starts_with(kPlayback) ? spec.substr(kPlayback.size()) : std::string();
}

std::unique_ptr<Device> OpenDevice(const std::string& spec, double press_depth,
                                   double press_speed) {
  if (spec == "sim-hand") return std::make_unique<SimHand>(press_depth, press_speed);
  const auto file = PlaybackFile(spec);
  if (!file.empty()) return std::make_unique<Playback>(file);
  const std::string name = spec.substr(0, spec.find(':'));
  const std::string option = name.size() < spec.size() ? spec.substr(name.size() + 1) : "";
  std::string accepted =
      "sim-hand, playback:FILE.csv, pointer (mouse, keys or gamepad, with --view)";
  for (const Driver& driver : Drivers()) {
    if (driver.name == name) return driver.open(option);
    accepted += ", " + std::string(driver.name);
  }
  throw std::invalid_argument("--device = " + spec + ": expected " + accepted);
}

}  // namespace palpate
