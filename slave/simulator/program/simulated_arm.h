// The manipulator of a simulated environment, as a driver's arm.
#pragma once

#include <stop_token>
#include <utility>

#include <Eigen/Core>
#include <palpate/arm.h>

#include "shared/link/thread_priority.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

// Its tip follows the target, and moves the tool of `environment`, whose true force it measures. It
// ends when `stop` is requested.
class SimulatedArm final : public Arm {
 public:
  // `p_S_home`: where the tip is first [m]. `environment` outlives the arm.
  SimulatedArm(SimulatedEnvironment& environment, Eigen::Vector3d p_S_home, std::stop_token stop)
      : environment_(environment),
        stop_(std::move(stop)),
        p_S_tip_(p_S_home),
        p_S_target_(std::move(p_S_home)) {}

  ArmReading Measure(double dt) override {
    if (!std::exchange(is_realtime_, true)) MakeThreadRealtime(kReadingPriority);
    p_S_tip_ = p_S_target_ + dt * velocity_;
    environment_.MoveTool(p_S_tip_, WhenUnsolved::kUseNearest);
    const Truth truth = environment_.truth();
    ArmReading reading;
    reading.tip = ToArray(p_S_tip_);
    if (truth.solved && !environment_.target()) reading.force = ToArray(truth.force);
    return reading;
  }
  void Go(const Vector& p_S_tip, const Vector& velocity) override {
    p_S_target_ = Eigen::Vector3d::Map(p_S_tip.data());
    velocity_ = Eigen::Vector3d::Map(velocity.data());
  }
  void Hold() override {
    p_S_target_ = p_S_tip_;
    velocity_.setZero();
  }
  [[nodiscard]] bool IsDone() const override { return stop_.stop_requested(); }

 private:
  static Vector ToArray(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

  SimulatedEnvironment& environment_;
  const std::stop_token stop_;
  Eigen::Vector3d p_S_tip_, p_S_target_;  // [m]
  bool is_realtime_ = false;              // the thread that measures: late reports are a fault
  Eigen::Vector3d velocity_{0, 0, 0};     // of the target [m/s]
};

}  // namespace palpate
