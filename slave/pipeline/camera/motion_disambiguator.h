// Whose motion a camera shows, its own or the object's: the object's edge tells both alike. Where
// the manipulator says that its tip is tells them apart.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "slave/pipeline/arm_consistency_check.h"

namespace palpate {

class MotionDisambiguator {
 public:
  // Of one picture, S [m]: where the tip is seen, and where it is on an object that rests. What is
  // no more than `still` [m] apart is no motion.
  void Update(const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_on_object,
              const EncoderReading& said, double still) noexcept {
    const double way = last_said_ ? (said.p_S_tip - *last_said_).norm() : 0;
    last_said_ = said.p_S_tip;
    const double moved = (p_S_seen - p_S_on_object).norm();
    const bool stands = !(moved > still);
    const Eigen::Vector3d offset = (objects_ || stands ? p_S_seen : p_S_on_object) - said.p_S_tip;
    if (!offset_ && stands) offset_ = offset;
    if (!offset_) return;
    // What the arm's registration or scale is off by grows with the tip's way, and is no motion.
    const double share = stands ? kFollow : is_decided_ ? std::min(1.0, way / kWay) : 0;
    *offset_ += share * (offset - *offset_);
    // A tip that moves is said to be where it was, or will be.
    if (stands || said.lag * way > kMargin * moved) return;
    const Eigen::Vector3d p_S_said = said.p_S_tip + *offset_;
    const double by_object = (p_S_on_object - p_S_said).norm() - (p_S_seen - p_S_said).norm();
    if (std::abs(by_object) < kMargin * moved) return;
    const bool objects = by_object > 0;
    in_a_row_ = objects == last_ ? in_a_row_ + 1 : 1;
    last_ = objects;
    if (in_a_row_ >= kSure) objects_ = objects, is_decided_ = true;
  }
  // Until it is told otherwise, the camera.
  [[nodiscard]] bool is_objects() const noexcept { return objects_; }
  void Reset() noexcept { *this = {}; }

 private:
  static constexpr double kFollow = 0.15;  // of the offset, per picture
  static constexpr double kWay = 10e-3;    // of the tip, over which it is followed besides [m]
  static constexpr double kMargin = 0.4;   // of the motion
  static constexpr int kSure = 3;          // pictures in a row
  std::optional<Eigen::Vector3d> offset_, last_said_;
  bool objects_ = false, is_decided_ = false, last_ = false;
  int in_a_row_ = 0;
};

}  // namespace palpate
