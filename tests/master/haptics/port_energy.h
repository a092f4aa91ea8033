// Computes energy, force and change of force that the operator gets through the device, from the
// recorded ticks only.
#pragma once

#include <algorithm>
#include <utility>

#include "master/haptics/haptic_loop.h"

namespace palpate {

// The energy is the maximum over all start times within an engagement, with or without contact. It
// is the energy that the operator got, less the energy created by holding the force from tick to
// tick, as far as the guaranteed damping of device and hand (b = 1 N s/m) dissipates it.
class PortEnergy {
 public:
  // Whether a contact that ends and begins again may return the energy that the operator put into
  // it.
  enum class LeftInContact { kLost, kReturned };

  explicit PortEnergy(LeftInContact left = LeftInContact::kLost)
      : returns_(left == LeftInContact::kReturned) {}

  void Add(const TickRecord& record) {
    const Eigen::Vector3d& sent = record.chain.sent;
    const Eigen::Vector3d dp = begun_ ? Eigen::Vector3d(record.p_M - p_) : force_;
    begun_ = true;
    const double dissipated = dp.squaredNorm() / 0.001;
    energy_ -= force_.dot(dp);
    energy_ += std::clamp(0.5 * (force_ - sent).dot(dp), -dissipated, dissipated);
    if (force_.isZero(0)) {
      if (was_shown_) left_ = std::max(0.0, energy_);
      energy_ = std::min(energy_, 0.0);
    }
    was_shown_ = !force_.isZero(0);
    const bool followed = std::exchange(follows_, record.state == OperatorState::kFollowing);
    if (returns_ && follows_ && !followed) energy_ += std::exchange(left_, 0.0);
    if (std::exchange(epoch_, record.epoch) != record.epoch) energy_ = std::max(energy_, 0.0);
    min_ = std::min(min_, energy_);
    p_ = record.p_M;
    peak_ = std::max(peak_, sent.norm());
    step_ = std::max(step_, (sent - force_).norm());
    force_ = sent;
  }
  [[nodiscard]] double min() const { return min_; }    // [J]
  [[nodiscard]] double peak() const { return peak_; }  // [N]
  [[nodiscard]] double step() const { return step_; }  // [N/ms]

 private:
  Eigen::Vector3d p_{0, 0, 0}, force_{0, 0, 0};
  const bool returns_;
  bool begun_ = false, follows_ = false, was_shown_ = false;
  std::uint32_t epoch_ = 0;
  double left_ = 0;  // remaining energy that the operator put into the last contact [J]
  double energy_ = 0, min_ = 0, peak_ = 0, step_ = 0;
};

}  // namespace palpate
