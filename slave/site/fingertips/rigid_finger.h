// A fingertip's outside as a rigid body: half sphere and cylinder behind it (paper B, equation 4),
// closed by another half sphere at the far end.
#pragma once

#include <Eigen/Core>

namespace palpate::site {

// Frame F.
struct RigidFinger {
  double radius = 7e-3;  // [m]
  double length = 0.02;  // of the cylinder, towards -x [m]

  // Signed distance of a point, < 0 inside [m].
  [[nodiscard]] double Distance(const Eigen::Vector3d& p_F) const noexcept;
  // Outward unit normal of the surface nearest to a point.
  [[nodiscard]] Eigen::Vector3d Normal(const Eigen::Vector3d& p_F) const noexcept;
  // Where an inner point leaves the finger if the finger came by moving along `direction_F` (unit):
  // it is pushed ahead. Zero: the nearest point of the surface.
  [[nodiscard]] Eigen::Vector3d PushOut(const Eigen::Vector3d& p_F,
                                        const Eigen::Vector3d& direction_F) const noexcept;
};

}  // namespace palpate::site
