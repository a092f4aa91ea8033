// The contact that the master renders by itself between two states (Adachi et al. 1995; design:
// LocalModel).
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace palpate {

// One-sided linear contact: f = force + stiffness (reference - p) while p lies beyond the plane,
// else 0. Frame S throughout. `force` is that of the object on the tool.
struct LocalModel {
  Eigen::Vector3d reference = Eigen::Vector3d::Zero();  // surface point at rest [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();    // outward unit normal [-]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();      // at the reference [N]
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // K [N/m]
  double valid_radius = 0;                              // range of |p - reference| [m]
  std::uint32_t revision = 0;  // rises when the master should blend; 0: no model
  bool in_contact = false;     // as the slave sees it; the master decides for itself

  [[nodiscard]] bool known() const { return revision != 0; }
  // How deep `p_S` lies below the plane [m]; negative outside.
  [[nodiscard]] double Penetration(const Eigen::Vector3d& p_S) const {
    return normal.dot(reference - p_S);
  }
};

}  // namespace palpate
