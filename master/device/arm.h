// A person's arm between what it means and where the hand is: a scripted hand and a pointer on a
// page both give way through it to the force they feel.
//
//   m a = k (x_intent - x) + b (v_intent - v) + f
//
// Mass, stiffness and damping ratio are our choice, of the size published for a hand that holds a
// stylus or knob firmly (0.1-1 kg, 200-1000 N/m, ratio 0.4-0.9); no single source is followed.
#pragma once

#include <Eigen/Core>

namespace palpate {

// Where the hand means to be. Frame M.
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

// Begins at rest at the origin of M. One thread.
class MovingArm {
 public:
  explicit MovingArm(const Arm& arm) : arm_(arm) {}

  // Goes on by `dt` [s] >= 0, in steps short enough to be stable. Real-time safe.
  void Step(double dt, const HandIntent& intent) noexcept;
  // The force on the hand [N], shown for Device::kLetGoAfter at most. Not finite: felt as zero.
  // Real-time safe.
  void ApplyForce(const Eigen::Vector3d& force_M) noexcept;
  [[nodiscard]] const Eigen::Vector3d& p_M() const noexcept { return p_; }  // [m]
  [[nodiscard]] const Eigen::Vector3d& v_M() const noexcept { return v_; }  // [m/s]
  [[nodiscard]] const Arm& arm() const noexcept { return arm_; }

 private:
  Arm arm_;
  Eigen::Vector3d p_{0, 0, 0}, v_{0, 0, 0}, force_{0, 0, 0};
  double held_ = 0;  // how long the force has been shown [s]
};

}  // namespace palpate
