// Model of the operator's arm: a mass on a spring and a damper between the intended and the actual
// device position. The simulated operator and the pointer yield to the force through it.
//
//   m a = k (x_intent - x) + b (v_intent - v) + f
//
// The values are chosen within the ranges published for a firm grip of a stylus or knob (0.1-1 kg,
// 200-1000 N/m, damping ratio 0.4-0.9). They come from no single source.
#pragma once

#include <Eigen/Core>

#include "master/device/haptic_device.h"

namespace palpate {

// Intended motion of the device. Frame M.
struct HandIntent {
  Eigen::Vector3d p_M{0, 0, 0};  // [m]
  Eigen::Vector3d v_M{0, 0, 0};  // [m/s]
  bool engaged = false;
};

struct Arm {
  double mass = 0.3;       // m [kg]
  double stiffness = 800;  // k [N/m]
  double damping = 21.7;   // b [N s/m]: 2 * 0.7 * sqrt(k m)
};

// The capabilities of a device whose force moves such an arm.
DeviceCapabilities CapabilitiesOfArm();

// Starts at rest at the origin of M. Not thread-safe.
class MovingArm {
 public:
  explicit MovingArm(const Arm& arm) : arm_(arm) {}

  // Advances by `dt` [s] >= 0, in steps short enough to be stable. Real-time safe.
  void Step(double dt, const HandIntent& intent) noexcept;
  // Sets the force on the device [N]. It acts for at most Device::kLetGoAfter. A force that is not
  // finite counts as zero. Real-time safe.
  void ApplyForce(const Eigen::Vector3d& force_M) noexcept;
  [[nodiscard]] const Eigen::Vector3d& p_M() const noexcept { return p_; }  // [m]
  [[nodiscard]] const Eigen::Vector3d& v_M() const noexcept { return v_; }  // [m/s]
  [[nodiscard]] const Arm& arm() const noexcept { return arm_; }

 private:
  Arm arm_;
  Eigen::Vector3d p_{0, 0, 0}, v_{0, 0, 0}, force_{0, 0, 0};
  double held_ = 0;  // time since the force was set [s]
};

}  // namespace palpate
