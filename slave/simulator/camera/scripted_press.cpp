#include "slave/simulator/camera/scripted_press.h"

#include <algorithm>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "slave/reference/planar/true_body.h"
#include "slave/simulator/camera/embryo.h"

namespace palpate {
namespace {

// Way from home to the true surface, straight ahead [m].
double GapAhead(const Scene& scene, const Eigen::Vector2d& direction_S) {
  const site::TrueBody body(scene);
  const Eigen::Vector2d home_O =
      body.X_SO().inverse() * Eigen::Vector2d(scene.manipulator.home.head<2>());
  if (body.Contains(home_O)) {
    throw std::invalid_argument(
        "manipulator.home: inside the object; accepted is a position outside");
  }
  const double far = 2 * body.larger_side() + (body.Nearest(home_O).p_O - home_O).norm();
  const Eigen::Vector2d direction_O = body.X_SO().linear().transpose() * direction_S;
  const auto entry = body.Entry(home_O, home_O + far * direction_O);
  if (!entry) {
    throw std::invalid_argument(
        "tool.direction: from manipulator.home the tool does not point at the object");
  }
  return (entry->p_O - home_O).norm();
}

constexpr int kStepsPerPicture =
    16;  // so that the tool's path between two pictures is followed, not jumped

}  // namespace

ScriptedPress::ScriptedPress(const Scene& scene, int presses) : home_(scene.manipulator.home) {
  if (!scene.tool || !(scene.tool->direction.norm() > 0)) {
    throw std::invalid_argument("tool: missing; a contact needs a tool with a direction");
  }
  const PressRequest press(scene);
  Eigen::Vector2d direction = scene.tool->direction.normalized();
  double way = 0;
  if (scene.site.embryo) {
    const Eigen::Vector2d to_target = (site::TargetOf(scene) - home_).head<2>();
    way = to_target.norm();
    direction = to_target / way;
  }
  gap_ = GapAhead(scene, direction);
  if (!scene.site.embryo) way = gap_ + press.depth;
  way_ = {way * direction.x(), way * direction.y(), 0};
  touch_ = InverseMinimumJerk(gap_ / way);
  const double ramp = kMinimumJerkPeak * way / press.speed;
  // Contact = hold + both ramps' deep parts; hold >= contact / 3 means hold >= one such part.
  const double hold = std::max(kHold, ramp * (1 - touch_));
  motion_ = {std::max(presses, 1), ramp, hold, kRest};
}

ScriptedCamera::ScriptedCamera(SimulatedSite& site, const Scene& scene)
    : site_(site), press_(scene), rate_(scene.sense.Find<Camera>()->rate) {
  site_.SetTime(0);
  site_.MoveTool(press_.Tip(0));
}

std::optional<Frame> ScriptedCamera::Next(const std::stop_token& stop) {
  const double t = static_cast<double>(sequence_) / rate_;
  if (stop.stop_requested() || t > press_.duration()) return std::nullopt;
  for (int step = kStepsPerPicture - 1; step >= 0 && sequence_ > 0; --step) {
    site_.SetTime(t);
    site_.MoveTool(press_.Tip(t - step / (kStepsPerPicture * rate_)));
  }
  Frame frame;
  frame.sensed_at = Time{} + Seconds(t);
  frame.sequence = ++sequence_;
  frame.image = site_.TakePicture();
  return frame;
}

std::string ScriptedCamera::description() const {
  return fmt::format("simulated camera, scripted contact, {:g} Hz", rate_);
}

}  // namespace palpate
