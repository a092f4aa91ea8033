// A simulated hand: an arm that follows a scripted intent and gives way to the force it feels.
//
//   m a = k (x_intent - x) + b (v_intent - v) + f
//
// Mass, stiffness and damping ratio are our choice, of the size published for a hand that holds a
// stylus or knob firmly (0.1-1 kg, 200-1000 N/m, ratio 0.4-0.9); no single source is followed.
#pragma once

#include <optional>

#include "master/device/press_script.h"

namespace palpate {

struct Arm {
  double mass = 0.3;       // m [kg]
  double stiffness = 800;  // k [N/m]
  double damping = 21.7;   // b [N s/m]: 2 * 0.7 * sqrt(k m)
};

class SimHand final : public Device {
 public:
  // See PressScript for what is accepted.
  SimHand(double press_depth, double press_speed, const Arm& arm = {});

  // Moves the arm to `now`, in steps short enough to be stable whatever the delay; more than one
  // second of absence is skipped.
  DeviceReading Read(Time now) noexcept override;
  // Not finite: felt as zero.
  void WriteForce(const Eigen::Vector3d& force_M) noexcept override;
  void Guide(const DeviceGuide& guide) noexcept override { guide_ = guide; }
  [[nodiscard]] bool finished() const noexcept override { return false; }
  [[nodiscard]] std::string description() const override;
  [[nodiscard]] double force_limit() const override { return 12; }

 private:
  Arm arm_;
  double press_depth_, press_speed_;
  PressScript script_;
  DeviceGuide guide_;
  std::optional<Time> start_;
  double t_ = 0;  // [s] since the first reading
  Eigen::Vector3d p_{0, 0, 0}, v_{0, 0, 0}, force_{0, 0, 0};
};

}  // namespace palpate
