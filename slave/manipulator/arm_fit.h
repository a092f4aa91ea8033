// Delay of a manipulator behind its targets, and the ratio of measured to commanded motion,
// estimated while it moves.
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Core>

namespace palpate {

//   p - u = (scale - 1) u - scale lag v + constant
//
// with the measured tip p, the target u at that moment and its velocity v: least squares over about
// the last `memory` seconds of motion. Frame S. Not thread-safe, allocation-free.
class ArmFit {
 public:
  ArmFit() = default;
  explicit ArmFit(double memory) : memory_(memory) {}
  struct Found {
    double lag = 0;    // [s]
    double scale = 1;  // [-]
  };

  // Adds one report, `dt` [s] after the one before.
  void Add(const Eigen::Vector3d& p_S_measured, const Eigen::Vector3d& p_S_target,
           const Eigen::Vector3d& v_S_target, double dt) noexcept {
    if (v_S_target.norm() < kAtRest || !(dt > 0)) return;  // a stationary arm gives no information
    const double keep = std::exp(-dt / memory_), share = 1 - keep;
    const Eigen::Vector3d y = p_S_measured - p_S_target;
    const double weight = weight_ * keep + share;
    const double step = share / weight;
    const Eigen::Vector3d du = p_S_target - mean_u_, dv = v_S_target - mean_v_, dy = y - mean_y_;
    mean_u_ += step * du;
    mean_v_ += step * dv;
    mean_y_ += step * dy;
    const double spread = (1 - step) * share;
    uu_ = keep * uu_ + spread * du.squaredNorm();
    uv_ = keep * uv_ + spread * du.dot(dv);
    vv_ = keep * vv_ + spread * dv.squaredNorm();
    uy_ = keep * uy_ + spread * du.dot(dy);
    vy_ = keep * vy_ + spread * dv.dot(dy);
    weight_ = weight;
  }
  // nullopt: too little motion to determine it.
  [[nodiscard]] std::optional<Found> found() const noexcept {
    const double determinant = uu_ * vv_ - uv_ * uv_;
    if (weight_ < kEnough || uu_ < weight_ * kWay * kWay || determinant < kDistinct * uu_ * vv_) {
      return std::nullopt;
    }
    const double stretch = (vv_ * uy_ - uv_ * vy_) / determinant;
    const double late = (uu_ * vy_ - uv_ * uy_) / determinant;
    const double scale = 1 + stretch;
    if (!(scale > kMinScale)) return Found{0, scale};
    return Found{-late / scale, scale};
  }

 private:
  static constexpr double kAtRest = 1e-4;  // [m/s]
  static constexpr double kEnough = 0.2;   // smallest filled share of the memory
  static constexpr double kWay = 3e-4;     // smallest rms spread of the targets [m]
  static constexpr double kDistinct =
      0.05;  // smallest independence of position and velocity; a single ramp has none
  static constexpr double kMinScale = 0.01;  // smallest scale for which the lag is determined

  double memory_ = 2;  // [s]
  double weight_ = 0;
  Eigen::Vector3d mean_u_ = Eigen::Vector3d::Zero(), mean_v_ = mean_u_, mean_y_ = mean_u_;
  double uu_ = 0, uv_ = 0, vv_ = 0, uy_ = 0, vy_ = 0;  // weighted, about the means
};

}  // namespace palpate
