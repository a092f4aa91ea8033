#include "master/device/sim_hand.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kRest = 0.2;           // rest before engaging [s]
constexpr double kSettle = 0.1;         // time engaged before moving [s]
constexpr double kEngageTimeout = 1.0;  // time engaged without a guide before giving up [s], plus
constexpr double kTrips = 3;            // additional round trips
constexpr double kHold = 1.0;           // at the peak, if the cycle has room [s]
// Smallest hold relative to the contact time of one ramp, so that the hold is at least a third.
constexpr double kHoldShare = 1.3;
constexpr double kBlind = 0.25;      // without a guide: wait before the retreat [s]
constexpr double kMaxRamp = 20;      // a longer ramp is not started [s]
constexpr double kMinRamp = 0.1;     // retreat [s]
constexpr double kMargin = 0.05;     // reserve at the end of a cycle [s]
constexpr double kCorrection = 8.0;  // gain of the visual correction [1/s]
constexpr double kPeakRate = 15.0 / 8;

double Ease(double tau) {
  return tau * tau * tau * (10 + tau * (6 * tau - 15));
}
double EaseRate(double tau) {
  return 30 * tau * tau * (1 - tau) * (1 - tau);
}

// Returns the relative time tau at which the ramp has covered the fraction `s` in [0, 1].
double InverseEase(double s) {
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (Ease(middle) < s ? low : high) = middle;
  }
  return low;
}

bool IsUsable(const DeviceGuide& guide) {
  return guide.known && std::isfinite(guide.gap_M) && guide.inward_M.allFinite() &&
         std::abs(guide.inward_M.norm() - 1) < 1e-3;
}

constexpr double kAbsence = 1;    // [s]
constexpr double kStrength = 15;  // largest force of the operator [N]

}  // namespace

PressScript::PressScript(double depth, double speed, double reach)
    : depth_(depth), speed_(speed), reach_(reach) {
  const auto require = [](bool usable, const char* name, double value, const char* accepted) {
    if (usable && std::isfinite(value)) return;
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) + accepted);
  };
  require(depth >= 0, "press depth", depth, " m: expected >= 0");
  require(speed > 0, "press speed", speed, " m/s: expected > 0");
  require(reach > 0, "reach", reach, " m: expected > 0");
}

HandIntent PressScript::Step(double t, double dt, const DeviceGuide& guide) noexcept {
  const bool usable = IsUsable(guide);
  blind_ = usable ? 0 : blind_ + dt;
  if (!usable && phase_ == Phase::kPress) since_ += dt;  // the ramp waits
  const double elapsed = t - since_;
  double rate = 0;
  switch (phase_) {
    case Phase::kRest:
      if (t >= next_press_ + kRest) Go(Phase::kEngage, t);
      break;
    case Phase::kEngage:
      if (elapsed >= kSettle && usable && PlanPress(t, guide)) break;
      if (elapsed > kEngageTimeout + kTrips * guide.round_trip) Release(t);
      break;
    case Phase::kPress: {
      const double tau = std::min(elapsed / ramp_, 1.0);
      advance_ = length_ * Ease(tau);
      rate = usable ? length_ * EaseRate(tau) / ramp_ : 0;
      if (blind_ > kBlind) {
        Retreat(t);
      } else if (tau >= 1) {
        Go(Phase::kHold, t);
      }
      break;
    }
    case Phase::kHold:
      if (usable) Correct(dt, guide);
      if (blind_ > kBlind || elapsed >= hold_) Retreat(t);
      break;
    case Phase::kRetreat: {
      const double tau = std::min(elapsed / ramp_, 1.0);
      advance_ = back_ + (length_ - back_) * (1 - Ease(tau));
      rate = -(length_ - back_) * EaseRate(tau) / ramp_;
      if (tau >= 1) Release(t);
      break;
    }
  }
  return {inward_ * advance_, inward_ * rate, phase_ != Phase::kRest};
}

void PressScript::Go(Phase phase, double t) noexcept {
  phase_ = phase;
  since_ = t;
}

// Plans one ramp to `depth_` below the surface. The hold uses the rest of the cycle, but at least a
// third of the contact.
bool PressScript::PlanPress(double t, const DeviceGuide& guide) noexcept {
  const double length = guide.gap_M + depth_;
  const double ramp = kPeakRate * length / speed_;
  if (!(length > 0 && ramp <= kMaxRamp)) return false;
  inward_ = guide.inward_M;
  length_ = length;
  back_ = guide.gap_M < 0 ? guide.gap_M - depth_ : 0;
  ramp_ = ramp;
  const double touching = 1 - InverseEase(std::clamp(guide.gap_M / length, 0.0, 1.0));
  const double left = next_press_ + kPeriod - kMargin - t - 2 * ramp_;
  hold_ = std::max(kHoldShare * touching * ramp_, std::min(kHold, left));
  correction_ = 0;
  Go(Phase::kPress, t);
  return true;
}

// Visual correction: the intent goes deeper until the tip is at its target. It never exceeds the
// reach of the arm.
void PressScript::Correct(double dt, const DeviceGuide& guide) noexcept {
  const double missing = depth_ + guide.gap_M;
  correction_ = std::clamp(correction_ + kCorrection * missing * dt, 0.0, reach_);
  advance_ = length_ + correction_;
}

// The correction fades with the force that it overcame, so that the tip keeps its speed.
void PressScript::Retreat(double t) noexcept {
  length_ = advance_;
  ramp_ = std::max(kPeakRate * (advance_ - correction_ - back_) / speed_, kMinRamp);
  Go(Phase::kRetreat, t);
}

void PressScript::Release(double t) noexcept {
  advance_ = 0;
  next_press_ = kPeriod * std::ceil(t / kPeriod);
  Go(Phase::kRest, t);
}

SimHand::SimHand(double press_depth, double press_speed, const Arm& arm)
    : HapticDevice(CapabilitiesOfArm()),
      press_depth_(press_depth),
      press_speed_(press_speed),
      script_(press_depth, press_speed, kStrength / arm.stiffness),
      hand_(arm) {}

DeviceOutput SimHand::DoWrite(const Wrench& wrench) noexcept {
  hand_.ApplyForce(wrench.force);
  return DeviceOutput::kOk;
}

DeviceReading SimHand::DoRead(Time now) noexcept {
  if (!start_) start_ = now;
  const double t = SecondsBetween(*start_, now);
  const double dt = std::clamp(t - t_, 0.0, kAbsence);
  t_ = std::max(t, t_);
  const HandIntent intent = script_.Step(t_, dt, guide_);
  hand_.Step(dt, intent);
  return {hand_.p_M(), hand_.v_M(), intent.engaged};
}

std::string SimHand::description() const {
  const Arm& arm = hand_.arm();
  return Formatted("sim-hand: %g kg, %g N/m, %g N s/m; presses %g mm at up to %g mm/s every %g s",
                   arm.mass, arm.stiffness, arm.damping, press_depth_ * 1e3, press_speed_ * 1e3,
                   PressScript::kPeriod);
}

}  // namespace palpate
