// Torque at the device for the moment that the slave reports.
//
//   t_M = (s_F / s_p) R_SM^T m_S
//
// A moment is a force times a length: forces scale by s_F and lengths by 1 / s_p towards the
// device. The same rule follows from power: rotations are not scaled, so t_M . w_M = (s_F / s_p)
// m_S . w_S, the ratio in which the force's power f_M . v_M = (s_F / s_p) f_S . v_S is scaled.
#pragma once

#include <Eigen/Core>

#include "master/haptics/force_chain.h"
#include "shared/geometry/teleop_transform.h"
#include "shared/state/slave_state.h"

namespace palpate {

// t_M [N m]. Real-time safe, like the next one.
inline Eigen::Vector3d MomentToMaster(const TeleopTransform& transform,
                                      const Eigen::Vector3d& m_S) noexcept {
  return transform.force_scale / transform.position_scale * (transform.R_SM.transpose() * m_S);
}

// The torque of a tick [N m]. States bring moments at the sensor's rate. Between them the lever arm
// is kept, so the torque has the share of the moment that the rendered force has of the estimated
// one, and that the sent force has of the scaled one: it fades, holds and saturates with the force.
// Zero if the moment is unknown.
Eigen::Vector3d TorqueAtDevice(const SlaveState& newest, const ForceChain& chain,
                               const TeleopTransform& transform) noexcept;

}  // namespace palpate
