// T^p and T^F: the mapping of positions from master frame M to slave frame S, and of forces back
// (paper A, 3.1).
//
//   p_S = s_p R_SM p_M + offset      F_M = s_F R_SM^T F_S      K_M = s_p s_F R_SM^T K_S R_SM
//
// Rotations follow relative to an engagement, with R_M(0) and R_S(0) when it begins:
//
//   R_S = R_SM R_M R_M(0)^T R_SM^T R_S(0)
//
// Forces are free vectors: the offset, which the clutch moves, never enters T^F. Power is preserved
// only if s_F = s_p .
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

struct TeleopTransform {
  double position_scale = 1;                           // s_p [-], > 0
  double force_scale = 1;                              // s_F [-], > 0
  Eigen::Matrix3d R_SM = Eigen::Matrix3d::Identity();  // rotation of M in S
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();    // S [m]
  struct Turn {
    Eigen::Quaterniond R_M, R_S;  // of the device in M, of the tool in S
  };
  std::optional<Turn> begin{};  // of the engagement; nullopt: rotations are not mapped

  [[nodiscard]] Eigen::Vector3d ToSlave(const Eigen::Vector3d& p_M) const;
  [[nodiscard]] Eigen::Vector3d ToMaster(const Eigen::Vector3d& p_S) const;
  [[nodiscard]] Eigen::Vector3d VelocityToSlave(const Eigen::Vector3d& v_M) const;
  [[nodiscard]] Eigen::Vector3d ForceToMaster(const Eigen::Vector3d& f_S) const;
  // Rotation of the tool in S for one of the device in M; `begin` is set.
  [[nodiscard]] Eigen::Quaterniond RotationToSlave(const Eigen::Quaterniond& R_M) const;
  // Sets the offset that maps `p_M` to `p_S`, so that engaging does not move the tool.
  void ZeroOffset(const Eigen::Vector3d& p_M, const Eigen::Vector3d& p_S);
};

}  // namespace palpate
