// Motion of the simulated tip towards its target: within a speed and a workspace, with the lag of a
// critically damped servo. Pure: time advances only in Step.
#pragma once

#include <Eigen/Core>

#include "slave/scene/scene.h"

namespace palpate {

//   x'' + 2 w x' + w^2 x = w^2 r,   r follows the target at no more than max_speed
//
// solved exactly over each step, so that any dt is stable. Behind a steady motion the tip lags by
// 2 / w = 2.5 ms. Frame S [m]. Not thread-safe.
class TipFollower {
 public:
  static constexpr double kLag = 2.5e-3;  // 2 / w [s]

  // Throws std::invalid_argument naming the key: home or workspace not finite, workspace empty,
  // max_speed not positive. A home outside the workspace is replaced by the nearest point inside.
  explicit TipFollower(const ManipulatorOptions& options);

  // Sets the target. A target outside the workspace is replaced by the nearest point inside.
  // Returns false and ignores a target that is not finite.
  bool Aim(const Eigen::Vector3d& p_S_target) noexcept;
  // Stops at the present position.
  void Hold() noexcept;
  // Sets the position to p_S [m], or the nearest point inside, at rest.
  void Place(const Eigen::Vector3d& p_S) noexcept;
  // Advances by `dt` [s]. A `dt` that is not positive or not finite is ignored.
  void Step(double dt) noexcept;

  [[nodiscard]] const Eigen::Vector3d& tip() const noexcept { return tip_; }
  [[nodiscard]] const Eigen::Vector3d& velocity() const noexcept { return velocity_; }  // [m/s]
  // Returns whether the workspace clipped the target, or the speed limit keeps the tip behind it.
  [[nodiscard]] bool at_limit() const noexcept { return clipped_ || too_slow_; }

 private:
  Eigen::Vector3d low_, high_;
  double max_speed_;
  Eigen::Vector3d target_, reference_, tip_, velocity_{0, 0, 0};
  bool clipped_ = false, too_slow_ = false;
};

}  // namespace palpate
