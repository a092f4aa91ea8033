// The newest local model, and its values at the tip's present position.
#pragma once

#include <mutex>

#include <Eigen/Core>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/slave_state.h"
#include "slave/live/operator_port.h"

namespace palpate {

// Thread-safe, short.
class CarriedModel {
 public:
  // `local` for a tip at p_S; p_S_arm: the encoder reading at that time [m].
  void Put(const LocalModel& local, const Eigen::Vector3d& p_S, const Eigen::Vector3d& p_S_arm) {
    const std::lock_guard lock(mutex_);
    local_ = local;
    p_S_ = p_S;
    p_S_arm_ = p_S_arm;
  }
  [[nodiscard]] LocalModel newest() const {
    const std::lock_guard lock(mutex_);
    return local_;
  }
  // Adds the values at the encoder reading p_S_arm_now [m]. A sample is at least 10 ms old, and a
  // fast arm moves half a millimetre in that time. Beyond its range the model is still the best
  // estimate. Its plane limits the depth also far from the contact: a convex object lies below it.
  // A punctured surface gives no force.
  void AddTo(ContactState* contact, const Eigen::Vector3d& p_S_arm_now, bool is_punctured) const {
    const std::lock_guard lock(mutex_);
    if (!local_.known()) return;
    const Eigen::Vector3d p_S = p_S_ + p_S_arm_now - p_S_arm_;
    const double depth = local_.Penetration(p_S);
    contact->depth_by_now = depth;
    contact->normal = local_.normal;
    const Eigen::Vector3d below = local_.reference - p_S, aside = below - depth * local_.normal;
    if (is_punctured || aside.norm() > local_.valid_radius) return;
    contact->stiffness = local_.normal.dot(local_.stiffness * local_.normal);
    if (!(depth > 0)) return;
    contact->force_by_now = (local_.force + local_.stiffness * below).norm();
    // The direction of a small force is not reliable.
    const double estimated = contact->force ? contact->force->norm() : 0;
    if (estimated < contact->force_by_now) contact->outward = local_.normal;
  }

 private:
  mutable PriorityInheritanceMutex mutex_;  // guards all
  LocalModel local_;
  Eigen::Vector3d p_S_{0, 0, 0}, p_S_arm_{0, 0, 0};
};

}  // namespace palpate
