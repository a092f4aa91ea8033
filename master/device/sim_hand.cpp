#include "master/device/sim_hand.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace palpate {
namespace {

constexpr double kStep = 0.00025;  // [s]; stable far beyond: 2 / omega is 39 ms, m / b 14 ms
constexpr double kLongest = 1;     // [s]
constexpr double kStrength = 15;   // a person does not push harder than this [N]

}  // namespace

SimHand::SimHand(double press_depth, double press_speed, const Arm& arm)
    : arm_(arm),
      press_depth_(press_depth),
      press_speed_(press_speed),
      script_(press_depth, press_speed, kStrength / arm.stiffness) {}

DeviceReading SimHand::Read(Time now) noexcept {
  if (!start_) start_ = now;
  const double t = SecondsBetween(*start_, now);
  const double dt = std::clamp(t - t_, 0.0, kLongest);
  t_ = std::max(t, t_);
  const HandIntent intent = script_.Step(t_, dt, guide_);
  const int steps = static_cast<int>(std::ceil(dt / kStep));
  const double h = steps > 0 ? dt / steps : 0;
  for (int i = 0; i < steps; ++i) {  // semi-implicit Euler
    const Eigen::Vector3d pull = arm_.stiffness * (intent.p_M - p_) + force_;
    v_ += h / arm_.mass * (pull + arm_.damping * (intent.v_M - v_));
    p_ += h * v_;
  }
  return {p_, v_, intent.engaged};
}

void SimHand::WriteForce(const Eigen::Vector3d& force_M) noexcept {
  force_ = force_M.allFinite() ? force_M : Eigen::Vector3d(0, 0, 0);
}

std::string SimHand::description() const {
  std::ostringstream text;
  text << "sim-hand: " << arm_.mass << " kg, " << arm_.stiffness << " N/m, " << arm_.damping
       << " N s/m; presses " << press_depth_ * 1e3 << " mm at up to " << press_speed_ * 1e3
       << " mm/s every " << PressScript::kPeriod << " s";
  return text.str();
}

}  // namespace palpate
