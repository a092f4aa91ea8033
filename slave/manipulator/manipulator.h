// Moves the tool. The pipeline and the service see only this; real arms come as other kinds of it.
#pragma once

#include <functional>
#include <memory>

#include <Eigen/Core>

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
  // Where its own encoders say the tip is, S [m]. Thread-safe.
  [[nodiscard]] virtual Eigen::Vector3d Tip() const noexcept = 0;
  // The last target was clipped by the workspace or the speed limit. Thread-safe.
  [[nodiscard]] virtual bool at_limit() const noexcept = 0;
  // It carries what is sensed; an arm that exists only here does so only in a simulated site.
  [[nodiscard]] virtual bool carries_tool() const noexcept = 0;
};

// The arm of the scene; so far there is the simulated one. `on_step` is called from the arm's
// thread after every step: it carries the tool of a simulated site; empty where the site is real.
// Throws std::invalid_argument naming the key.
std::unique_ptr<Manipulator> MakeManipulator(const Scene& scene, Manipulator::OnStep on_step);

}  // namespace palpate
