// Target of the tool's rotation for a driver: it follows an operator's rotation at no more than an
// angular speed, and holds otherwise. Pure: time advances only in Step.
#pragma once

#include <algorithm>
#include <optional>

#include <Eigen/Geometry>

namespace palpate {

// Rotations of the tool in S. Not thread-safe.
class ToolRotation {
 public:
  // `max_speed` > 0 [rad/s].
  explicit ToolRotation(double max_speed) : max_speed_(max_speed) {}

  // Begins with the first report of a driver; nullopt if it measures no rotation.
  void Begin(const std::optional<Eigen::Quaterniond>& measured) noexcept {
    rotation_ = measured;
    turns_ = too_slow_ = false;
  }
  // Follows `target`, from `measured` on.
  void Follow(const Eigen::Quaterniond& target, const Eigen::Quaterniond& measured) noexcept {
    if (!turns_) Place(measured);
    turns_ = true;
    target_ = target;
  }
  // Holds the rotation `measured`. Keeps the last one if there was no Follow since the last Hold.
  void Hold(const std::optional<Eigen::Quaterniond>& measured) noexcept {
    if (turns_ && measured) Place(*measured);
    turns_ = too_slow_ = false;
  }
  // Advances by `dt` >= 0 [s], along the shorter rotation.
  void Step(double dt) noexcept {
    if (!turns_ || !rotation_) return;
    const double way = rotation_->angularDistance(target_), reach = max_speed_ * dt;
    too_slow_ = way > reach;
    if (way > 0) rotation_ = rotation_->slerp(std::min(1.0, reach / way), target_).normalized();
  }

  // nullopt: the driver measures none.
  [[nodiscard]] const std::optional<Eigen::Quaterniond>& rotation() const { return rotation_; }
  // Returns whether the speed limit keeps it behind its target.
  [[nodiscard]] bool at_limit() const { return too_slow_; }

 private:
  // A quaternion and its negative are one rotation: the sign continues.
  void Place(const Eigen::Quaterniond& measured) noexcept {
    const bool flips = rotation_ && rotation_->dot(measured) < 0;
    rotation_ = measured;
    if (flips) rotation_->coeffs() *= -1;
  }

  double max_speed_;
  std::optional<Eigen::Quaterniond> rotation_;
  Eigen::Quaterniond target_ = Eigen::Quaterniond::Identity();
  bool turns_ = false, too_slow_ = false;
};

}  // namespace palpate
