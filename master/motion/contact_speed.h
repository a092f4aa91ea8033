// Speed limit near the contact: the commanded position approaches the surface at no more than
//
//   v = max(V, gap / t),   t = kAhead
//
// and follows every other motion of the device at once. A spring K between device and command lets
// the operator notice the lag e. With the contact's force F(c) at the command, the operator's work
// exceeds the energy that the contact receives by
//
//   int e (K - dF/dc) dc >= 0   where dc >= 0 (the command approaches),
//
// so the lag creates no energy if K is at least the rendered stiffness of the contact.
#pragma once

#include <Eigen/Core>

#include "master/device/device.h"

namespace palpate {

class ContactSpeed {
 public:
  static constexpr double kAhead = 0.25;  // time to the surface within which the limit acts [s]

  // `speed`: V, of the tool [m/s]; 0: no limit.
  explicit ContactSpeed(double speed) : speed_(speed) {}

  // Begins an engagement at `p_M` [m]. Real-time safe, like the next one.
  void Begin(const Eigen::Vector3d& p_M) noexcept { command_ = p_M; }
  // The commanded position for the device at `p_M` after `dt` [s]. A surface that becomes unknown
  // keeps its direction until the command has caught up.
  const Eigen::Vector3d& Step(const Eigen::Vector3d& p_M, const DeviceGuide& surface,
                              double position_scale, double dt) noexcept;
  // `v_M` [m/s], without the approach beyond the limit of the last step.
  [[nodiscard]] Eigen::Vector3d Limited(const Eigen::Vector3d& v_M) const noexcept;
  [[nodiscard]] bool is_on() const noexcept { return speed_ > 0; }

 private:
  double speed_;
  Eigen::Vector3d command_{0, 0, 0};    // [m]
  Eigen::Vector3d inward_M_{0, -1, 0};  // of the last known surface
  double max_speed_ = 0;                // largest approach of the device in the last step [m/s]
  bool lags_ = false;
};

}  // namespace palpate
