#include "slave/site/fingertips/scripted_touch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

namespace palpate {
namespace {

constexpr int kStepsPerSample = 4;  // so that the hand's path is followed, not jumped

}  // namespace

ScriptedTouch::ScriptedTouch(TactileSite& site, const Scene& scene, int presses)
    : site_(site), rate_(scene.sense.Find<Tactile>()->rate) {
  const PressRequest press(scene);
  if (!std::isfinite(site_.gap())) {
    throw std::invalid_argument(
        "sense.tactile: the fingertips do not meet the object on their path");
  }
  const double way = site_.gap() + press.depth;
  way_ = way * site_.approach();
  start_ = std::max(scene.sense.Find<Tactile>()->rest_samples, 0) / rate_ + kSettle;
  motion_ = {std::max(presses, 1), kMinimumJerkPeak * std::abs(way) / press.speed, kHold, kRest};
}

std::optional<TactileFrame> ScriptedTouch::Next(const std::stop_token& stop) {
  const double t = static_cast<double>(sequence_) / rate_;
  if (stop.stop_requested() || t > duration()) return std::nullopt;
  for (int step = kStepsPerSample - 1; step >= 0; --step) {
    site_.MoveTool(Tip(t - step / (kStepsPerSample * rate_)));
  }
  ++sequence_;
  return site_.TakeSample(Time{} + Seconds(t));
}

std::string ScriptedTouch::description() const {
  return fmt::format("simulated fingertips, {} scripted contact{}, {:g} Hz", motion_.presses,
                     motion_.presses == 1 ? "" : "s", rate_);
}

}  // namespace palpate
