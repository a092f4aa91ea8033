#include "slave/site/camera/scripted_press.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "slave/site/camera/true_body.h"
#include "slave/site/minimum_jerk.h"

namespace palpate {
namespace {

double Positive(double value, const char* key, const char* unit) {
  if (value > 0 && std::isfinite(value)) return value;
  throw std::invalid_argument(std::string(key) + " = " + std::to_string(value) + " " + unit +
                              ": accepted is > 0");
}

// Way from home to the true surface, straight ahead [m].
double GapAhead(const Scene& scene, const Eigen::Vector2d& direction_S) {
  const site::TrueBody body(scene);
  const Eigen::Vector2d home_O =
      body.X_SO().inverse() * Eigen::Vector2d(scene.manipulator.home.head<2>());
  if (body.Contains(home_O)) {
    throw std::invalid_argument("manipulator.home: inside the body; accepted is a place outside");
  }
  const double far = 2 * body.larger_side() + (body.Nearest(home_O).p_O - home_O).norm();
  const Eigen::Vector2d direction_O = body.X_SO().linear().transpose() * direction_S;
  const auto entry = body.Entry(home_O, home_O + far * direction_O);
  if (!entry) {
    throw std::invalid_argument(
        "tool.direction: from manipulator.home the tool does not point at the body");
  }
  return (entry->p_O - home_O).norm();
}

}  // namespace

ScriptedPress::ScriptedPress(const Scene& scene, int presses)
    : presses_(std::max(presses, 1)), home_(scene.manipulator.home) {
  if (!scene.tool || !(scene.tool->direction.norm() > 0)) {
    throw std::invalid_argument("tool: missing; a press needs one that points somewhere");
  }
  const double depth = Positive(scene.operator_options.press_depth, "operator.press.depth", "m");
  const double speed =
      std::min(Positive(scene.operator_options.press_speed, "operator.press.speed", "m/s"),
               Positive(scene.manipulator.max_speed, "manipulator.max_speed", "m/s"));
  const Eigen::Vector2d direction = scene.tool->direction.normalized();
  gap_ = GapAhead(scene, direction);
  const double way = gap_ + depth;
  way_ = {way * direction.x(), way * direction.y(), 0};
  touch_ = InverseMinimumJerk(gap_ / way);
  ramp_ = kMinimumJerkPeak * way / speed;
  // Contact = hold + both ramps' deep parts; hold >= contact / 3 means hold >= one such part.
  hold_ = std::max(kHold, ramp_ * (1 - touch_));
  period_ = 2 * ramp_ + hold_ + kRest;
}

Eigen::Vector3d ScriptedPress::Tip(double t) const noexcept {
  if (!(t > 0 && t < duration())) return home_;
  const double in_press = std::fmod(t, period_);
  if (in_press >= 2 * ramp_ + hold_) return home_;
  const double back = in_press - ramp_ - hold_;
  const double u = back > 0 ? 1 - back / ramp_ : std::min(in_press / ramp_, 1.0);
  return home_ + MinimumJerk(u) * way_;
}

}  // namespace palpate
