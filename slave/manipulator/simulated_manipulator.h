// A manipulator without hardware, for recorded or live images without an arm: its tip follows the
// targets as TipFollower computes, from call to call.
#pragma once

#include <mutex>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/tip_follower.h"

namespace palpate {

class SimulatedManipulator : public Manipulator {
 public:
  // Throws the exceptions of TipFollower.
  explicit SimulatedManipulator(const ManipulatorOptions& options) : follower_(options) {}

  bool Command(const Eigen::Vector3d& p_S_target) noexcept override {
    const std::lock_guard lock(mutex_);
    return Present().Aim(p_S_target);
  }
  void Hold() noexcept override {
    const std::lock_guard lock(mutex_);
    Present().Hold();
  }
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override {
    const std::lock_guard lock(mutex_);
    return Present().tip();
  }
  [[nodiscard]] bool at_limit() const noexcept override {
    const std::lock_guard lock(mutex_);
    return Present().at_limit();
  }
  [[nodiscard]] bool carries_tool() const noexcept override { return false; }

 private:
  // Returns the follower at the present time. Requires mutex_ to be held.
  TipFollower& Present() const noexcept {
    const Time now = Clock::now();
    follower_.Step(SecondsBetween(stepped_at_, now));
    stepped_at_ = now;
    return follower_;
  }

  mutable PriorityInheritanceMutex mutex_;  // guards everything below
  mutable TipFollower follower_;
  mutable Time stepped_at_ = Clock::now();
};

}  // namespace palpate
