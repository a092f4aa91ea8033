// Mapping of the device's axes to frame M, for a device whose orientation differs from its driver's
// assumption. A signed permutation P: orthogonal, so that it changes no length, force or power.
//
//   p_M = P p_D      R_M = P R_D P^T      w_M = det(P) P w_D      f_D = P^T f_M
//   t_D = det(P) P^T t_M
//
// det(P) = -1 mirrors. Rotation rates and torques are axial vectors, so they change sign then.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "master/device/device.h"

namespace palpate {

inline constexpr std::string_view kAxisLetters = "xyz";

class AxisMap {
 public:
  AxisMap() = default;  // the identity
  // `P`: one entry of 1 or -1 in each row and column. Throws std::invalid_argument otherwise.
  explicit AxisMap(const Eigen::Matrix3d& P);
  // Parses the device's axes for right, up and towards the operator: `x,y,z`, `-z,y,x`. Throws
  // std::invalid_argument.
  static AxisMap Parse(std::string_view text);

  // Returns a reading of the device in M. Real-time safe, like the next ones.
  [[nodiscard]] DeviceReading ToMaster(const DeviceReading& reading_D) const noexcept;
  [[nodiscard]] Eigen::Vector3d ToDevice(const Eigen::Vector3d& f_M) const noexcept {
    return P_.transpose() * f_M;
  }
  [[nodiscard]] Eigen::Vector3d TorqueToDevice(const Eigen::Vector3d& t_M) const noexcept {
    return P_.determinant() * (P_.transpose() * t_M);
  }
  [[nodiscard]] const Eigen::Matrix3d& P() const noexcept { return P_; }

 private:
  Eigen::Matrix3d P_ = Eigen::Matrix3d::Identity();
};

}  // namespace palpate
