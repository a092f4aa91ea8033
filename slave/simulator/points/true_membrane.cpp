#include "slave/simulator/points/true_membrane.h"

#include <algorithm>
#include <stdexcept>
#include <variant>

namespace palpate::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMaxDistance = 1e3;  // tools farther away are ignored, in radii
// Distance from the centre within which presses are expected, in radii.
constexpr double kNear = 1.5;

const MembraneGeometry& GeometryOf(const Scene& scene) {
  const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry);
  if (membrane) return *membrane;
  throw std::invalid_argument("object.geometry: the simulator expects a membrane");
}

PressCache::Plan PlanOf(const Scene& scene, const Eigen::Isometry3d& X_SO,
                        const MembraneResolution& resolution) {
  if (!scene.tool || !(scene.tool->width > 0)) {
    throw std::invalid_argument(
        "tool.width: missing; the simulator expects the diameter of the tool, > 0");
  }
  return {.geometry = GeometryOf(scene),
          .material = scene.object.material,
          .width = scene.tool->width,
          .face = FaceOf(*scene.tool),
          .home_radius = (X_SO.inverse() * scene.manipulator.home).head<2>().norm(),
          .press_depth = scene.operator_options.press_depth,
          .prestress = scene.model.prestress,
          .resolution = resolution};
}

}  // namespace

TrueMembrane::TrueMembrane(const Scene& scene, const MembraneResolution& resolution)
    : X_SO_(TruePose(scene)),
      rim_(GeometryOf(scene).radius),
      presses_(PlanOf(scene, X_SO_, resolution)) {
  now_.p_S_tip = scene.manipulator.home;
  now_.indentation.rim = rim_;
}

void TrueMembrane::MoveTool(const Vector3d& p_S_tip, WhenUnsolved when_unsolved) {
  if (!p_S_tip.allFinite()) return;
  if ((p_S_tip - X_SO_.translation()).norm() > kMaxDistance * rim_) return;
  const std::lock_guard moving(moving_);
  Move(p_S_tip, when_unsolved);
}

void TrueMembrane::Move(const Vector3d& p_S_tip, WhenUnsolved when_unsolved) {
  const Vector3d p_O = X_SO_.inverse() * p_S_tip;
  const double radius = p_O.head<2>().norm();
  Now next;
  next.p_S_tip = p_S_tip;
  next.indentation.rim = rim_;
  next.in_contact = radius < rim_ && p_O.z() < 0;
  const double pressed = std::min(radius, presses_.farthest());
  if (next.in_contact) {
    Indentation& indentation = next.indentation;
    indentation.depth = -p_O.z();
    indentation.place_O = radius > 0 ? Vector2d(pressed / radius * p_O.head<2>()) : Vector2d(0, 0);
    const PressCache::Presses presses = when_unsolved == WhenUnsolved::kWait
                                            ? presses_.Await(pressed, indentation.depth)
                                            : presses_.Find(pressed, indentation.depth);
    indentation.parts = presses.parts;
    next.solved = presses.solved && radius <= presses_.farthest();
    for (const Indentation::Part& part : indentation.parts) {
      const auto& depth_steps = part.press->depth_steps;
      next.solved =
          next.solved && !depth_steps.empty() && depth_steps.back()->depth >= indentation.depth;
    }
  } else if (radius < kNear * rim_) {
    presses_.Expect(pressed);
  }
  const std::lock_guard lock(mutex_);
  now_ = std::move(next);
}

TrueMembrane::Now TrueMembrane::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

}  // namespace palpate::simulation
