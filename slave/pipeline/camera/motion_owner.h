// Whose motion a camera shows, its own or the object's: the object's edge tells both alike. Where
// the manipulator says that its tip is tells them apart.
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "slave/pipeline/arm_watch.h"

namespace palpate {

class MotionOwner {
 public:
  // Of one picture, S [m]: where the tip is seen, and where it is on an object that rests. What is
  // no more than `still` [m] apart is no motion.
  void See(const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_on_object,
           const ArmWord& said, double still) noexcept {
    const double way = last_said_ ? (said.p_S_tip - *last_said_).norm() : 0;
    last_said_ = said.p_S_tip;
    const double moved = (p_S_seen - p_S_on_object).norm();
    if (!(moved > still)) {
      const Eigen::Vector3d offset = p_S_seen - said.p_S_tip;
      if (!offset_) offset_ = offset;
      *offset_ += kFollow * (offset - *offset_);
      return;
    }
    // A tip that moves is said to be where it was, or will be.
    if (!offset_ || said.lag * way > kMargin * moved) return;
    const Eigen::Vector3d p_S_said = said.p_S_tip + *offset_;
    const double by_object = (p_S_on_object - p_S_said).norm() - (p_S_seen - p_S_said).norm();
    if (std::abs(by_object) < kMargin * moved) return;
    const bool objects = by_object > 0;
    against_ = objects == objects_ ? 0 : against_ + 1;
    if (against_ >= kSure) objects_ = objects, against_ = 0;
  }
  // Until it is told otherwise, the camera.
  [[nodiscard]] bool is_objects() const noexcept { return objects_; }
  void Reset() noexcept { *this = {}; }

 private:
  static constexpr double kFollow = 0.03;  // of the offset, per picture
  static constexpr double kMargin = 0.4;   // of the motion
  static constexpr int kSure = 3;          // pictures in a row
  std::optional<Eigen::Vector3d> offset_, last_said_;
  bool objects_ = false;
  int against_ = 0;
};

}  // namespace palpate
