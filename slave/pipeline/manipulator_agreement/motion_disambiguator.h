// Decides whether camera or object moves: the object's edge shows both alike, the encoders
// distinguish them.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"

namespace palpate {

class MotionDisambiguator {
 public:
  // For one image, S [m]: the measured tip, and the tip relative to an object at rest. Differences
  // up to `still` [m] are no motion.
  void Update(const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_on_object,
              const EncoderReading& said, double still) noexcept {
    const double way = last_said_ ? (said.p_S_tip - *last_said_).norm() : 0;
    last_said_ = said.p_S_tip;
    const double moved = (p_S_seen - p_S_on_object).norm();
    const bool stands = !(moved > still);
    const Eigen::Vector3d offset = (objects_ || stands ? p_S_seen : p_S_on_object) - said.p_S_tip;
    if (!offset_ && stands) offset_ = offset;
    if (!offset_) return;
    // An error of the encoders' registration or scale grows with the tip's path, and is no motion.
    const double share = stands ? kFollow : is_decided_ ? std::min(1.0, way / kWay) : 0;
    *offset_ += share * (offset - *offset_);
    // The reading of a moving tip is of an earlier or later time.
    if (stands || said.lag * way > kMargin * moved) return;
    const Eigen::Vector3d p_S_said = said.p_S_tip + *offset_;
    const double by_object = (p_S_on_object - p_S_said).norm() - (p_S_seen - p_S_said).norm();
    if (std::abs(by_object) < kMargin * moved) return;
    const bool objects = by_object > 0;
    in_a_row_ = objects == last_ ? in_a_row_ + 1 : 1;
    last_ = objects;
    if (in_a_row_ >= kSure) objects_ = objects, is_decided_ = true;
  }
  // Assumes that the camera moves, until it is detected otherwise.
  [[nodiscard]] bool is_objects() const noexcept { return objects_; }
  void Reset() noexcept { *this = {}; }

 private:
  static constexpr double kFollow = 0.15;  // share of the offset, per image
  static constexpr double kWay = 10e-3;   // path of the tip for a second estimate of the offset [m]
  static constexpr double kMargin = 0.4;  // of the motion
  static constexpr int kSure = 3;         // consecutive images
  std::optional<Eigen::Vector3d> offset_, last_said_;
  bool objects_ = false, is_decided_ = false, last_ = false;
  int in_a_row_ = 0;
};

}  // namespace palpate
