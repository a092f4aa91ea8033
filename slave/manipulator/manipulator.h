// Moves the tool. The pipeline and the service see only this; real arms come as other kinds of it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "slave/manipulator/driven_arm.h"
#include "slave/scene/scene.h"

namespace palpate {

class Manipulator {
 public:
  // Told where the tip is, S [m].
  using OnStep = std::function<void(const Eigen::Vector3d& p_S_tip)>;

  virtual ~Manipulator() = default;
  Manipulator() = default;
  Manipulator(const Manipulator&) = delete;
  Manipulator& operator=(const Manipulator&) = delete;

  // Where the tip should be, S [m]. Thread-safe, latest wins. Outside the workspace it goes to the
  // nearest place inside; not finite: ignored, and false.
  virtual bool Command(const Eigen::Vector3d& p_S_target) noexcept = 0;
  // Stop where it is. Thread-safe.
  virtual void Hold() noexcept = 0;
  // The emergency stop: stands, with brakes if it has any, until it is told otherwise. Thread-safe.
  virtual void Stop() noexcept { Hold(); }
  // Where its own encoders say the tip is, S [m]. Thread-safe.
  [[nodiscard]] virtual Eigen::Vector3d Tip() const noexcept = 0;
  // Where they said it was at `t`, about the last half second; an arm that keeps no account: where
  // it is now.
  [[nodiscard]] virtual Eigen::Vector3d TipAt(Time /*t*/) const noexcept { return Tip(); }
  // Rises where the places told before mean nothing any more: another driver counts from elsewhere.
  // Thread-safe.
  [[nodiscard]] virtual std::uint32_t frame() const noexcept { return 0; }
  // The last target was clipped by the workspace or the speed limit. Thread-safe.
  [[nodiscard]] virtual bool at_limit() const noexcept = 0;
  // It carries what is sensed; an arm that exists only here does so only in a simulated site.
  [[nodiscard]] virtual bool carries_tool() const noexcept = 0;

  // It does not move the tool, or nobody knows where the tool is: it stands, and goes on only after
  // a new engagement. Thread-safe.
  [[nodiscard]] virtual bool is_faulty() const noexcept { return false; }
  // nullopt: it exists only here.
  [[nodiscard]] virtual std::optional<ArmHealth> health() const { return std::nullopt; }
  // Force of the object on the tool as a sensor of the arm's measures it, S [N]. No estimator reads
  // it. nullopt: there is none. Thread-safe.
  [[nodiscard]] virtual std::optional<Eigen::Vector3d> measured_force() const noexcept {
    return std::nullopt;
  }
  // Where a client drives it; null: nobody does.
  [[nodiscard]] virtual DrivenArm* driven() noexcept { return nullptr; }
};

// The arm of the scene. `on_step` is called from the arm's
// thread after every step: it carries the tool of a simulated site; empty where the site is real.
// Throws std::invalid_argument or
// std::runtime_error naming the key.
std::unique_ptr<Manipulator> MakeManipulator(const Scene& scene, Manipulator::OnStep on_step);

}  // namespace palpate
