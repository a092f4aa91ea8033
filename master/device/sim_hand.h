// The simulated operator: the arm model follows a scripted intent and yields to the force.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "master/device/arm.h"
#include "master/device/haptic_device.h"

namespace palpate {

// The scripted intent, repeated every 4 s: rest, engage, approach, press to `depth` below the
// surface, hold, retreat, disengage.
//
//   s(tau) = 10 tau^3 - 15 tau^4 + 6 tau^5,   peak of ds/dtau = 15/8 at tau = 1/2
//
// Source: minimum-jerk reaching (Flash & Hogan 1985, rest to rest). The motion is straight along
// the guided direction through the origin of M, where the device rests. A tool that is inside the
// object at the engagement is first retracted to `depth` above the surface.
class PressScript {
 public:
  static constexpr double kPeriod = 4;  // cycles begin at multiples of it [s]

  // `depth` [m] >= 0 is below the surface. `speed` [m/s] > 0 is the peak speed. `reach` [m] > 0 is
  // the largest extra intent that overcomes the force. Throws std::invalid_argument otherwise.
  PressScript(double depth, double speed, double reach);

  // The intent at `t` [s] since the start, `dt` [s] after the last call. While `guide` is unknown
  // it goes no deeper, and after a quarter of a second it retreats. Real-time safe.
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
  double length_ = 0;      // of the ramp in, or start of the ramp out [m]
  double back_ = 0;        // end of the ramp out [m]; negative: farther out than the start
  double ramp_ = 0;        // duration of the ramp [s]
  double hold_ = 0;        // duration of the hold [s]
  double advance_ = 0;     // present intent along `inward_` [m]
  double blind_ = 0;       // time since the guide became unknown [s]
  double correction_ = 0;  // part of `advance_` that overcomes the force [m]
};

class SimHand final : public HapticDevice {
 public:
  // Accepts the same values as PressScript.
  SimHand(double press_depth, double press_speed, const Arm& arm = {});

  void Guide(const DeviceGuide& guide) noexcept override { guide_ = guide; }
  [[nodiscard]] std::string description() const override;

 protected:
  // Advances the arm to `now` in stable steps. A gap of more than one second is skipped.
  DeviceReading DoRead(Time now) noexcept override;
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  double press_depth_, press_speed_;
  PressScript script_;
  DeviceGuide guide_;
  std::optional<Time> start_;
  double t_ = 0;  // [s] since the first reading
  MovingArm hand_;
};

}  // namespace palpate
