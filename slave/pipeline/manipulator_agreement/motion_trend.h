// Extrapolates the motion of an object: a straight line through its last few positions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

// Allocation-free. Frame S.
class MotionTrend {
 public:
  // `position` [m] with its error, one standard deviation in total [m].
  void Add(Time at, const Eigen::Vector3d& position, double sigma) noexcept {
    if (count_ > 0 && at <= samples_[At(count_ - 1)].at) return;  // repeated image
    samples_[At(count_++)] = {at, position};
    const std::size_t n = std::min(count_, kImages);
    velocity_.setZero();
    error_ = 0;
    if (n < kMinImages) return;
    double t_mean = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      t_mean += SecondsBetween(at, Sampled(i).at) / static_cast<double>(n);
      mean += Sampled(i).position / static_cast<double>(n);
    }
    double square = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double t = SecondsBetween(at, Sampled(i).at) - t_mean;
      square += t * t;
      velocity_ += t * (Sampled(i).position - mean);
    }
    velocity_ /= square;
    // Deviation at the ends of a curved path, from which the error of the slope follows.
    double bent = 0;
    for (const std::size_t i : {std::size_t{0}, n - 1}) {
      const double t = SecondsBetween(at, Sampled(i).at) - t_mean;
      bent = std::max(bent, (Sampled(i).position - mean - t * velocity_).norm() / std::abs(t));
    }
    error_ = std::hypot(sigma / std::sqrt(square), kBends * bent);
    // A jump is not a line either: a position with a larger error is not extrapolated.
    if (error_ > kKnown * velocity_.norm()) velocity_.setZero();
  }
  [[nodiscard]] const Eigen::Vector3d& velocity() const noexcept { return velocity_; }  // [m/s]
  [[nodiscard]] double error() const noexcept { return error_; }  // one standard deviation [m/s]

 private:
  static constexpr std::size_t kImages = 12, kMinImages = 4;
  // Error, of the velocity [-]. [tuned: EstimatesAndPatchFollowTheObject]
  static constexpr double kKnown = 0.5;
  // Slope of a parabola at its end relative to the errors of its ends. [-] [tuned:
  // EstimatesAndPatchFollowTheObject]
  static constexpr double kBends = 3;
  struct Sample {
    Time at{};
    Eigen::Vector3d position{0, 0, 0};
  };
  static std::size_t At(std::size_t i) noexcept { return i % kImages; }
  [[nodiscard]] const Sample& Sampled(std::size_t i) const noexcept {
    return samples_[At(count_ - std::min(count_, kImages) + i)];
  }
  std::array<Sample, kImages> samples_;
  std::size_t count_ = 0;
  Eigen::Vector3d velocity_{0, 0, 0};
  double error_ = 0;
};

}  // namespace palpate
