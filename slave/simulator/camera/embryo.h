// Properties of a simulated embryo beyond elasticity: stiffening of the membrane, puncture, and the
// target of the injection (paper A, 4.2). Drawn by the scene's seed; used by reports only.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "slave/scene/scene.h"

namespace palpate::simulation {

class Embryo {
 public:
  // Range of targets relative to the embryo's radius: along the tool's path and across.
  static constexpr double kTargetAlong = 0.45, kTargetAcross = 0.12;

  // `radius` [m]; `direction_O`: along which the tool points, unit.
  Embryo(const EmbryoSite& options, std::uint32_t seed, double radius,
         const Eigen::Vector2d& direction_O);

  // Returns the membrane's force divided by the linear one at `depth` [m]:
  //
  //   1                                    up to the depth d0 = linear_to
  //   1 + stiffening (depth / d0 - 1)^2    beyond
  //
  // Linear to about 100 um: paper A, 4.2, after Kim et al. 2006; the behaviour beyond is an
  // assumption.
  [[nodiscard]] double Stiffening(double depth) const noexcept;
  // Returns the depth at which the membrane breaks in the insertion with this number, from 0 [m].
  [[nodiscard]] double PunctureDepth(int insertion) const noexcept;
  // Target of the pipette, frame O [m].
  [[nodiscard]] const Eigen::Vector2d& target_O() const { return target_O_; }
  // Drag of the liquid on the tool that moves at `velocity` [m/s]: [N].
  [[nodiscard]] Eigen::Vector2d Drag(const Eigen::Vector2d& velocity) const noexcept {
    return -options_.drag * velocity;
  }

 private:
  EmbryoSite options_;
  std::uint32_t seed_;
  Eigen::Vector2d target_O_{0, 0};
};

// Returns the target of the scene's embryo at its true position, S [m]. Throws like TrueBody;
// std::bad_optional_access if the scene has none.
Eigen::Vector3d TargetOf(const Scene& scene);

}  // namespace palpate::simulation
