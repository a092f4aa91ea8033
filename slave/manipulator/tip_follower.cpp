#include "slave/manipulator/tip_follower.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate {

TipFollower::TipFollower(const ManipulatorOptions& options)
    : low_(options.workspace_min), high_(options.workspace_max), max_speed_(options.max_speed) {
  if (!(max_speed_ > 0) || !std::isfinite(max_speed_)) {
    throw std::invalid_argument("manipulator.max_speed = " + std::to_string(max_speed_) +
                                " m/s: expected > 0");
  }
  if (!low_.allFinite() || !high_.allFinite() || (low_.array() > high_.array()).any()) {
    throw std::invalid_argument("manipulator.workspace: expected finite with min <= max");
  }
  if (!options.home.allFinite()) {
    throw std::invalid_argument("manipulator.home: expected finite numbers");
  }
  target_ = reference_ = tip_ = options.home.cwiseMax(low_).cwiseMin(high_);
}

bool TipFollower::Aim(const Eigen::Vector3d& p_S_target) noexcept {
  if (!p_S_target.allFinite()) return false;
  target_ = p_S_target.cwiseMax(low_).cwiseMin(high_);
  clipped_ = target_ != p_S_target;
  return true;
}

void TipFollower::Hold() noexcept {
  target_ = reference_ = tip_;
  velocity_.setZero();
  clipped_ = too_slow_ = false;
}

void TipFollower::Place(const Eigen::Vector3d& p_S) noexcept {
  if (!p_S.allFinite()) return;
  tip_ = p_S.cwiseMax(low_).cwiseMin(high_);
  Hold();
}

void TipFollower::Step(double dt) noexcept {
  if (!(dt > 0) || !std::isfinite(dt)) return;
  const Eigen::Vector3d way = target_ - reference_;
  const double reach = max_speed_ * dt, distance = way.norm();
  too_slow_ = distance > reach;
  reference_ = too_slow_ ? Eigen::Vector3d(reference_ + reach / distance * way) : target_;

  constexpr double w = 2 / kLag;
  const double decay = std::exp(-w * dt);
  const Eigen::Vector3d offset = tip_ - reference_;
  const Eigen::Vector3d slope = velocity_ + w * offset;
  tip_ = reference_ + decay * (offset + dt * slope);
  velocity_ = decay * (slope - w * (offset + dt * slope));
  // The result stays inside in spite of rounding and of the servo's stopping distance.
  tip_ = tip_.cwiseMax(low_).cwiseMin(high_);
}

}  // namespace palpate
