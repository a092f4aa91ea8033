#include "master/motion/operator_motion.h"

#include <algorithm>
#include <stdexcept>

namespace palpate {

using Eigen::Vector3d;

void MotionOptions::ParseLocks(const std::string& text) {
  locked = false;
  for (std::size_t at = 0; at <= text.size(); at += 2) {
    const std::size_t axis =
        at < text.size() ? kAxisLetters.find(text[at]) : std::string_view::npos;
    const bool is_last = at + 1 == text.size();
    if (axis == std::string_view::npos || (!is_last && text[at + 1] != ',')) {
      throw std::invalid_argument("--lock " + text +
                                  ": expected axes of the master, for example z or x,z");
    }
    locked[static_cast<int>(axis)] = true;
    if (is_last) return;
  }
}

OperatorMotion::OperatorMotion(const MotionOptions& options, double stiffest)
    : options_(options), speed_(options.contact_speed), contact_stiffness_(stiffest) {
  for (const Fixture& region : options.fixtures) springs_.emplace_back(region);
  if (options.box) springs_.emplace_back(*options.box);
  const auto locks = options.locked.count();
  const auto springs = static_cast<double>(springs_.size()) + static_cast<double>(locks);
  contact_stiffness_ = stiffest / ((springs > 0 ? 2 : 1) + (speed_.is_on() ? 1 : 0));
  if (springs > 0) spring_stiffness_ = std::min(options.stiffness, contact_stiffness_ / springs);
  kept_M_ = (!options.locked).cast<double>();
}

DeviceGuide OperatorMotion::guide() const noexcept {
  DeviceGuide guide = surface_;
  guide.inward_M = axes().ToDevice(guide.inward_M);
  return guide;
}

bool OperatorMotion::IsClutched(const DeviceReading& reading) const noexcept {
  return options_.clutch_button > 0 &&
         (reading.status.buttons >> (options_.clutch_button - 1) & 1U) != 0;
}

void OperatorMotion::Begin(const Vector3d& p_M, const TeleopTransform& transform) noexcept {
  const Vector3d p_S = transform.ToSlave(p_M);
  for (FixtureSpring& spring : springs_) spring.Begin(p_S);
  box_lower_ = box_upper_ = p_S;
  speed_.Begin(p_M);
}

// Limits to the box, or to the direction towards it for a tool that began outside.
Vector3d OperatorMotion::InBox(const Vector3d& p_S) noexcept {
  const Vector3d &lower = options_.box->point, &upper = options_.box->direction;
  box_lower_ = lower.cwiseMin(box_lower_.cwiseMax(p_S));
  box_upper_ = upper.cwiseMax(box_upper_.cwiseMin(p_S));
  return p_S.cwiseMax(box_lower_).cwiseMin(box_upper_);
}

DeviceReading OperatorMotion::Command(const DeviceReading& reading,
                                      const TeleopTransform& transform,
                                      const Situation& now) noexcept {
  springs_force_.setZero();
  through_box_.setIdentity();
  is_active_ = false;
  if (now.epoch != epoch_) {
    epoch_ = now.epoch;
    engaged_at_ = reading.p_M;
    has_begun_ = false;
  }
  if (!now.engaged) return reading;
  DeviceReading command = reading;
  const Vector3d locked = options_.locked.select(engaged_at_, reading.p_M);
  command.p_M = locked;
  command.v_M = kept_M_.cwiseProduct(reading.v_M);
  springs_force_ = spring_stiffness_ * (locked - reading.p_M);
  if (now.follows) {
    if (!has_begun_) Begin(locked, transform);
    has_begun_ = true;
    Pull(transform, locked);
    LimitSpeed(transform.position_scale, now.dt, &command);
    if (options_.box) KeepInBox(transform, &command);
  }
  is_active_ = command.p_M != reading.p_M || !springs_force_.isZero(0);
  return command;
}

void OperatorMotion::Pull(const TeleopTransform& transform, const Vector3d& p_M) noexcept {
  Vector3d pull(0, 0, 0);  // of all fixtures, S [m]
  for (FixtureSpring& spring : springs_) pull += spring.Pull(transform.ToSlave(p_M));
  const Vector3d pull_M = transform.R_SM.transpose() * pull / transform.position_scale;
  springs_force_ += spring_stiffness_ * kept_M_.cwiseProduct(pull_M);
}

// The lag's spring is as stiff as the contact may be; see ContactSpeed.
void OperatorMotion::LimitSpeed(double position_scale, double dt, DeviceReading* command) noexcept {
  DeviceGuide surface = surface_;  // approached along the axes that are free
  surface.inward_M = kept_M_.cwiseProduct(surface.inward_M).stableNormalized();
  const Vector3d p_M = command->p_M;
  command->p_M = speed_.Step(p_M, surface, position_scale, dt);
  command->v_M = speed_.Limited(command->v_M);
  springs_force_ += contact_stiffness_ * (command->p_M - p_M);
}

void OperatorMotion::KeepInBox(const TeleopTransform& transform, DeviceReading* command) noexcept {
  const Vector3d p_S = transform.ToSlave(command->p_M), inside = InBox(p_S);
  if (inside == p_S) return;
  const Vector3d kept_S = (p_S.array() == inside.array()).cast<double>();
  through_box_ = transform.R_SM.transpose() * kept_S.asDiagonal() * transform.R_SM;
  command->p_M = transform.ToMaster(inside);
  command->v_M = through_box_ * command->v_M;
}

Vector3d OperatorMotion::ForceAtDevice(const Vector3d& f_M) const noexcept {
  if (!is_active_) return f_M;
  return kept_M_.cwiseProduct(Vector3d(through_box_ * f_M)) + springs_force_;
}

}  // namespace palpate
