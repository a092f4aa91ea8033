// A simulated hand: an arm that follows a scripted intent and gives way to the force it feels.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "master/device/arm.h"
#include "master/device/device.h"

namespace palpate {

// What a person at the master means to do: press, hold, let go, again and again. Every 4 s: rest,
// engage, approach, press `depth` beyond the surface, hold, retreat, disengage.
//
//   s(tau) = 10 tau^3 - 15 tau^4 + 6 tau^5,   peak of ds/dtau = 15/8 at tau = 1/2
//
// Source: minimum-jerk reaching (Flash & Hogan 1985, rest to rest). Frame M, straight along the
// guided direction through the origin, where the hand rests. A tool that is inside already when the
// hand engages is drawn out to `depth` before the surface, so that the next press begins there.
class PressScript {
 public:
  static constexpr double kPeriod = 4;  // presses begin at multiples of it [s]

  // `depth` [m] >= 0 beyond the surface, `speed` [m/s] > 0 is the peak on the way in and out,
  // `reach` [m] > 0 how far beyond the plan the hand may aim to overcome the force. Throws
  // std::invalid_argument otherwise.
  PressScript(double depth, double speed, double reach);

  // The intent at `t` [s] since the start, `dt` [s] after the last call. While `guide` is unknown
  // the hand goes no deeper; after a quarter of a second of it, back. Real-time safe.
  HandIntent Step(double t, double dt, const DeviceGuide& guide) noexcept;

 private:
  enum class Phase : std::uint8_t { kRest, kEngage, kPress, kHold, kRetreat };

  void Go(Phase phase, double t) noexcept;
  bool PlanPress(double t, const DeviceGuide& guide) noexcept;
  void Correct(double dt, const DeviceGuide& guide) noexcept;
  void Retreat(double t) noexcept;
  void Release(double t) noexcept;

  double depth_, speed_, reach_;
  Phase phase_ = Phase::kRest;
  double since_ = 0;       // when the phase began [s]
  double next_press_ = 0;  // when the next cycle begins [s]
  Eigen::Vector3d inward_{0, -1, 0};
  double length_ = 0;      // of the ramp in, or where the ramp out begins [m]
  double back_ = 0;        // where the ramp out ends [m]; negative: farther out than it began
  double ramp_ = 0;        // how long it takes [s]
  double hold_ = 0;        // how long the hand stays [s]
  double advance_ = 0;     // how far in the hand aims now [m]
  double blind_ = 0;       // how long the guide has been unknown [s]
  double correction_ = 0;  // of that, added to overcome the force [m]
};

class SimHand final : public Device {
 public:
  // See PressScript for what is accepted.
  SimHand(double press_depth, double press_speed, const Arm& arm = {});

  // Moves the arm to `now`, in steps short enough to be stable whatever the delay; more than one
  // second of absence is skipped.
  DeviceReading Read(Time now) noexcept override;
  // Not finite: felt as zero.
  void WriteForce(const Eigen::Vector3d& force_M) noexcept override { hand_.ApplyForce(force_M); }
  void Guide(const DeviceGuide& guide) noexcept override { guide_ = guide; }
  [[nodiscard]] bool finished() const noexcept override { return false; }
  [[nodiscard]] std::string description() const override;
  [[nodiscard]] double force_limit() const override { return 12; }

 private:
  double press_depth_, press_speed_;
  PressScript script_;
  DeviceGuide guide_;
  std::optional<Time> start_;
  double t_ = 0;  // [s] since the first reading
  MovingArm hand_;
};

}  // namespace palpate
