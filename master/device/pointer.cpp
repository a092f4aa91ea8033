#include "master/device/pointer.h"

#include <algorithm>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kMaxLeap = 0.1;  // longest simulated time between readings [s]

}  // namespace

Pointer::Pointer(double speed, const Arm& arm)
    : HapticDevice(CapabilitiesOfArm()), speed_(speed), hand_(arm) {
  RequirePositive("the pointer's speed", speed);
}

DeviceOutput Pointer::DoWrite(const Wrench& wrench) noexcept {
  hand_.ApplyForce(wrench.force);
  return DeviceOutput::kOk;
}

DeviceReading Pointer::DoRead(Time now) noexcept {
  const double dt = last_ ? std::clamp(SecondsBetween(*last_, now), 0.0, kMaxLeap) : 0;
  last_ = now;
  TakeAim(now);
  MoveIntent(now, dt);
  hand_.Step(dt, intent_);
  return {hand_.p_M(), hand_.v_M(), intent_.engaged};
}

void Pointer::TakeAim(Time now) noexcept {
  const PointerAim* newest = aims_.Take();
  const bool is_another = newest != nullptr && newest->page != aim_.page;
  if (newest != nullptr) aim_ = *newest;
  used_ = aim_.stamp;
  const double silence = SecondsBetween(aim_.received_at, now);
  const bool is_silent = silence > MaxSilence(aim_.gap);
  if (!aim_.engaged) let_go_ = true;
  if (intent_.engaged && is_silent) let_go_ = false;
  if (is_another) let_go_ = true;
  if (is_silent && !let_go_) silence_ = silence;
  const bool engaged = aim_.engaged && !is_silent && let_go_;
  if (engaged && (is_another || !intent_.engaged)) {
    begin_ = intent_.p_M = hand_.p_M();
    begin_aim_ = aim_.p_M;
  }
  if (engaged) silence_ = 0;
  holds_ = intent_.engaged = engaged;
}

// A disengaged device stays at its position, and so does that of a silent page.
void Pointer::MoveIntent(Time now, double dt) noexcept {
  intent_.v_M.setZero();
  if (!intent_.engaged || dt == 0) {
    if (!intent_.engaged) intent_.p_M = hand_.p_M();
    return;
  }
  if (SecondsBetween(aim_.received_at, now) > kHoldAfter) return;
  const Eigen::Vector3d way = begin_ + aim_.p_M - begin_aim_ - intent_.p_M;
  const double longest = speed_ * dt, length = way.norm();
  const Eigen::Vector3d step = length > longest ? Eigen::Vector3d(way * (longest / length)) : way;
  intent_.p_M += step;
  intent_.v_M = step / dt;
}

std::string Pointer::description() const {
  const Arm& arm = hand_.arm();
  return Formatted(
      "pointer: mouse, keys or gamepad on the page, up to %g mm/s; %g kg, %g N/m, %g N s/m",
      1e3 * speed_, arm.mass, arm.stiffness, arm.damping);
}

}  // namespace palpate
