#include "master/motion/contact_speed.h"

#include <algorithm>

namespace palpate {

const Eigen::Vector3d& ContactSpeed::Step(const Eigen::Vector3d& p_M, const DeviceGuide& surface,
                                          double position_scale, double dt) noexcept {
  if (surface.known) inward_M_ = surface.inward_M;
  double excess = 0;  // [m]
  if (is_on() && (surface.known || lags_)) {
    const double near = surface.known ? surface.gap_M / kAhead : 0;
    max_speed_ = std::max(speed_ / position_scale, near);
    excess = std::max(0.0, (p_M - command_).dot(inward_M_) - max_speed_ * dt);
  }
  lags_ = excess > 0;
  return command_ = p_M - excess * inward_M_;
}

Eigen::Vector3d ContactSpeed::Limited(const Eigen::Vector3d& v_M) const noexcept {
  return lags_ ? Eigen::Vector3d(v_M - std::max(0.0, v_M.dot(inward_M_) - max_speed_) * inward_M_)
               : v_M;
}

}  // namespace palpate
