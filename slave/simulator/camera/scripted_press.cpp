#include "slave/simulator/camera/scripted_press.h"

#include <algorithm>
#include <stdexcept>

#include "slave/reference/planar/true_body.h"
#include "slave/simulator/camera/embryo.h"

namespace palpate {
namespace {

// Returns the distance from home to the true surface, straight ahead [m].
double GapAhead(const Scene& scene, const Eigen::Vector2d& direction_S) {
  const simulation::TrueBody body(scene);
  const Eigen::Vector2d home_O =
      body.X_SO().inverse() * Eigen::Vector2d(scene.manipulator.home.head<2>());
  if (body.Contains(home_O)) {
    throw std::invalid_argument("manipulator.home: inside the object; expected a position outside");
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

constexpr double kHold = 1, kRest = 0.5;  // [s]

}  // namespace

PressMotion ScriptedPress(const Scene& scene) {
  PressMotion motion{.home = scene.manipulator.home, .rest = kRest};
  Eigen::Vector2d direction = scene.tool->direction.normalized();
  double way = 0;
  if (scene.site.embryo) {
    const Eigen::Vector2d to_target = (simulation::TargetOf(scene) - motion.home).head<2>();
    way = to_target.norm();
    direction = to_target / way;
  }
  const double gap = GapAhead(scene, direction);
  if (!scene.site.embryo) way = gap + scene.operator_options.press_depth;
  motion.way = {way * direction.x(), way * direction.y(), 0};
  motion.ramp = kMinimumJerkPeak * way / PressSpeed(scene);
  // Contact = hold + both ramps' deep parts; hold >= contact / 3 means hold >= one such part.
  motion.hold = std::max(kHold, motion.ramp * (1 - InverseMinimumJerk(gap / way)));
  return motion;
}

}  // namespace palpate
