#include "shared/geometry/teleop_transform.h"

namespace palpate {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d TeleopTransform::ToSlave(const Vector3d& p_M) const {
  return position_scale * (R_SM * p_M) + offset;
}

Vector3d TeleopTransform::ToMaster(const Vector3d& p_S) const {
  return R_SM.transpose() * (p_S - offset) / position_scale;
}

Vector3d TeleopTransform::VelocityToSlave(const Vector3d& v_M) const {
  return position_scale * (R_SM * v_M);
}

Vector3d TeleopTransform::ForceToMaster(const Vector3d& f_S) const {
  return force_scale * (R_SM.transpose() * f_S);
}

Quaterniond TeleopTransform::RotationToSlave(const Quaterniond& R_M) const {
  const Quaterniond q_SM(R_SM);
  return (q_SM * R_M * begin->R_M.conjugate() * q_SM.conjugate() * begin->R_S).normalized();
}

void TeleopTransform::ZeroOffset(const Vector3d& p_M, const Vector3d& p_S) {
  offset = p_S - position_scale * (R_SM * p_M);
}

}  // namespace palpate
