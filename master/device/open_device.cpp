#include <stdexcept>

#include "master/device/device.h"
#include "master/device/playback.h"
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
  throw std::invalid_argument("--device = " + spec +
                              ": accepted is sim-hand, playback:FILE.csv or pointer (with --view)");
}

}  // namespace palpate
