// Observes the energy of the torque at the device's handle, and weakens the torque when the handle
// has received more than it gave: one-port time-domain passivity (Hannaford & Ryu 2002).
//
//   W += -t . dr,   dr: rotation vector of the handle during the tick, t: torque held meanwhile
//   W < -W_0:  t loses its component along the last dr, if that would turn the handle further
//
// A torque is never reversed. W_0 is the credit for a contact that turns by itself; each new
// engagement renews it. While no torque is rendered, W is at most zero, so that nothing is saved.
// The energy beyond W_0 is at most the work of the ticks in which the rotation turns around.
#pragma once

#include <algorithm>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

class TurnPassivity {
 public:
  static constexpr double kEnergyCredit = 0.5e-3;  // W_0, as of the force [J]

  // Adds a tick: the handle has the orientation `q`, of unit length, after it had the torque `t`
  // [N m]. Real-time safe, like the next one.
  void Observe(const Eigen::Quaterniond& q, const Eigen::Vector3d& t, bool engaged) noexcept;
  // Returns `t` [N m], weakened if energy is missing.
  [[nodiscard]] Eigen::Vector3d Apply(const Eigen::Vector3d& t) const noexcept;
  [[nodiscard]] double balance() const noexcept { return balance_; }  // W [J]

 private:
  Eigen::Quaterniond last_{1, 0, 0, 0};
  Eigen::Vector3d turned_{0, 0, 0};  // dr [rad]
  bool has_last_ = false, engaged_ = false;
  double balance_ = 0;
};

}  // namespace palpate
