// The finger model: a half sphere at the tip, a cylinder behind it (paper B, equation 4).
#pragma once

#include <optional>

#include <Eigen/Core>

namespace palpate {

// Frame F.
struct FingerSurface {
  double radius = 7e-3;  // [m]
  // The point of the surface outward of `c_F`: from the origin where c_x >= 0, from the axis at c_x
  // behind it. nullopt: `c_F` is the origin, or on the axis, or not finite.
  [[nodiscard]] std::optional<Eigen::Vector3d> Project(const Eigen::Vector3d& c_F) const noexcept;
  // Outward unit normal at a point of the surface.
  [[nodiscard]] Eigen::Vector3d Normal(const Eigen::Vector3d& p_F) const noexcept;
};

}  // namespace palpate
