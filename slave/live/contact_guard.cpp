#include "slave/live/contact_guard.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// A retreat has ended within the distance that the arm travels in this time [s].
constexpr double kArrived = 0.005;
// A retreat ends after kRetreatTimes its duration at full speed plus kRetreatLonger [s].
constexpr double kRetreatTimes = 2, kRetreatLonger = 1;
// At a guard, motions up to the distance that the arm travels in this time are tremor, not a deeper
// press [s].
constexpr double kTremor = 0.02;
constexpr double kFalls = 0.95;  // fraction of the force at the guard below which the guard ends
// Time within which samples show the effect of the tool's last motion; the longer one applies while
// the force is unknown [s].
constexpr double kSeenWithin = 0.3, kWaitedFor = 10;

}  // namespace

bool ContactGuard::Check(Time now, const ContactState& contact, bool follows) noexcept {
  const double estimated = contact.force ? contact.force->norm() : 0;
  const double force = std::max(estimated, contact.force_by_now);
  const double depth = std::max(contact.depth, contact.depth_by_now);
  const double falls = outward_ ? kFalls : 1;
  const bool is_reached =
      force > falls * limits_.force_guard || depth > falls * limits_.depth_guard;
  const bool is_led_beyond = is_reached && !outward_ && (follows || unseen_);
  if (contact.force) outward_.reset();  // while the force is unknown, the guard stays
  if (is_reached) outward_ = contact.outward;
  SetFloor(contact, force);
  if (follows) followed_at_ = now;
  ContinueRetreat(now);
  const double since = SecondsBetween(followed_at_, now);
  unseen_ = follows || (unseen_ && since < (contact.force ? kSeenWithin : kWaitedFor));
  return is_led_beyond;
}

void ContactGuard::SetFloor(const ContactState& contact, double force) noexcept {
  floor_.reset();
  if (contact.normal.isZero()) return;
  const double depth = contact.depth_by_now;
  double deepest = kFloor * limits_.depth_guard;
  if (contact.stiffness > 0) {
    const double room = (kFloor * limits_.force_guard - force) / contact.stiffness;
    deepest = std::min(deepest, std::max(0.0, depth) + room);
  }
  if (!std::isfinite(deepest)) return;
  floor_.emplace(contact.normal, manipulator_.Tip() + (depth - deepest) * contact.normal);
}

void ContactGuard::BeginRetreat(Time now, const ContactState& contact) noexcept {
  if (!limits_.guard_retracts) return;
  const double depth = std::max(contact.depth, contact.depth_by_now);
  retreat_ = manipulator_.Tip() + depth * contact.outward;
  retreat_frame_ = manipulator_.frame();
  const double takes = WayTo(*retreat_) / limits_.max_speed;
  retreat_until_ = now + Seconds(kRetreatTimes * takes + kRetreatLonger);
}

// An arm with a fault loses its target, and its driver may then count from another origin.
void ContactGuard::ContinueRetreat(Time now) noexcept {
  if (!retreat_) return;
  const bool is_same = manipulator_.frame() == retreat_frame_;
  if (is_same && WayTo(*retreat_) < kArrived * limits_.max_speed) return EndRetreat();
  if (!is_same || now > retreat_until_) {
    EndRetreat();
    manipulator_.Hold();
  } else if (!manipulator_.is_faulty()) {
    manipulator_.Command(*retreat_);
  }
}

std::optional<Eigen::Vector3d> ContactGuard::Permitted(const Eigen::Vector3d& target,
                                                       Events* events) const noexcept {
  if (outward_) {
    // Moves only along the normal, because on a curved surface a lateral motion may lead deeper.
    const Eigen::Vector3d tip = manipulator_.Tip();
    const double out = (target - tip).dot(*outward_);
    if (-out > kTremor * limits_.max_speed) return std::nullopt;
    if (out < 0) events->Add(Event::kLimit);
    return tip + std::max(0.0, out) * *outward_;
  }
  if (!floor_) return target;
  return target + std::max(0.0, -floor_->signedDistance(target)) * floor_->normal();
}

double ContactGuard::WayTo(const Eigen::Vector3d& p_S) const noexcept {
  const Eigen::Vector3d within =
      p_S.cwiseMax(limits_.workspace_min).cwiseMin(limits_.workspace_max);
  return (within - manipulator_.Tip()).norm();
}

}  // namespace palpate
