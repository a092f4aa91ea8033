#include "slave/site/fingertips/scripted_touch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "slave/site/minimum_jerk.h"

namespace palpate {
namespace {

constexpr int kStepsPerSample = 4;  // so that the hand's path is followed, not jumped

double Positive(double value, const char* key, const char* unit) {
  if (value > 0 && std::isfinite(value)) return value;
  throw std::invalid_argument(fmt::format("{} = {:g} {}: accepted is > 0", key, value, unit));
}

}  // namespace

ScriptedTouch::ScriptedTouch(TactileSite& site, const Scene& scene, int presses)
    : site_(site), presses_(std::max(presses, 1)), rate_(scene.sense.Find<Tactile>()->rate) {
  const double depth = Positive(scene.operator_options.press_depth, "operator.press.depth", "m");
  const double speed =
      std::min(Positive(scene.operator_options.press_speed, "operator.press.speed", "m/s"),
               Positive(scene.manipulator.max_speed, "manipulator.max_speed", "m/s"));
  if (!std::isfinite(site_.gap())) {
    throw std::invalid_argument(
        "sense.tactile: the fingertips do not meet the object on the way of their hand");
  }
  const double way = site_.gap() + depth;
  way_ = way * site_.approach();
  start_ = std::max(scene.sense.Find<Tactile>()->rest_samples, 0) / rate_ + kSettle;
  ramp_ = kMinimumJerkPeak * std::abs(way) / speed;
  period_ = 2 * ramp_ + kHold + kRest;
}

Eigen::Vector3d ScriptedTouch::Tip(double t) const noexcept {
  const double since = t - start_;
  if (!(since > 0 && t < duration())) return site_.home();
  const double in_press = std::fmod(since, period_);
  if (in_press >= 2 * ramp_ + kHold) return site_.home();
  const double back = in_press - ramp_ - kHold;
  const double u = back > 0 ? 1 - back / ramp_ : std::min(in_press / ramp_, 1.0);
  return site_.home() + MinimumJerk(u) * way_;
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
  return fmt::format("simulated fingertips, {} scripted press{}, {:g} Hz", presses_,
                     presses_ == 1 ? "" : "es", rate_);
}

}  // namespace palpate
