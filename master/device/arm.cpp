#include "master/device/arm.h"

#include <cmath>

namespace palpate {
namespace {

constexpr double kArmStep = 0.00025;  // [s]; stable far beyond: 2 / omega is 39 ms, m / b 14 ms

}  // namespace

DeviceCapabilities CapabilitiesOfArm() {
  DeviceCapabilities own;
  own.actuated_dof = 3;
  own.simulated = true;
  own.force = 12;
  return own;
}

void MovingArm::Step(double dt, const HandIntent& intent) noexcept {
  const int steps = static_cast<int>(std::ceil(dt / kArmStep));
  const double h = steps > 0 ? dt / steps : 0;
  for (int i = 0; i < steps; ++i) {  // semi-implicit Euler
    held_ += h;
    if (held_ > Device::kLetGoAfter) force_.setZero();
    const Eigen::Vector3d pull = arm_.stiffness * (intent.p_M - p_) + force_;
    v_ += h / arm_.mass * (pull + arm_.damping * (intent.v_M - v_));
    p_ += h * v_;
  }
}

void MovingArm::ApplyForce(const Eigen::Vector3d& force_M) noexcept {
  force_ = force_M.allFinite() ? force_M : Eigen::Vector3d(0, 0, 0);
  held_ = 0;
}

}  // namespace palpate
