// Extrapolates an object's position: a straight line through the last few images.
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
  // `place` [m] with its error, one standard deviation in total [m].
  void Add(Time at, const Eigen::Vector3d& place, double sigma) noexcept {
    if (count_ > 0 && at <= seen_[At(count_ - 1)].at) return;  // repeated image
    seen_[At(count_++)] = {at, place};
    const std::size_t n = std::min(count_, kPictures);
    velocity_.setZero();
    error_ = 0;
    if (n < kFewest) return;
    double t_mean = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      t_mean += SecondsBetween(at, Seen(i).at) / static_cast<double>(n);
      mean += Seen(i).place / static_cast<double>(n);
    }
    double square = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double t = SecondsBetween(at, Seen(i).at) - t_mean;
      square += t * t;
      velocity_ += t * (Seen(i).place - mean);
    }
    velocity_ /= square;
    // For a curved path the deviation at the ends gives the error of the slope.
    double bent = 0;
    for (const std::size_t i : {std::size_t{0}, n - 1}) {
      const double t = SecondsBetween(at, Seen(i).at) - t_mean;
      bent = std::max(bent, (Seen(i).place - mean - t * velocity_).norm() / std::abs(t));
    }
    error_ = std::hypot(sigma / std::sqrt(square), kBends * bent);
    // A jump is not a line either: a position with a larger error is not extrapolated.
    if (error_ > kKnown * velocity_.norm()) velocity_.setZero();
  }
  [[nodiscard]] const Eigen::Vector3d& velocity() const noexcept { return velocity_; }  // [m/s]
  [[nodiscard]] double error() const noexcept { return error_; }  // one standard deviation [m/s]
  void Reset() noexcept { *this = {}; }

 private:
  static constexpr std::size_t kPictures = 12, kFewest = 4;
  static constexpr double kKnown = 0.5;  // error, of the velocity [-]
  static constexpr double kBends =
      3;  // slope of a parabola at its end relative to the errors of its ends
  struct Sight {
    Time at{};
    Eigen::Vector3d place{0, 0, 0};
  };
  static std::size_t At(std::size_t i) noexcept { return i % kPictures; }
  [[nodiscard]] const Sight& Seen(std::size_t i) const noexcept {
    return seen_[At(count_ - std::min(count_, kPictures) + i)];
  }
  std::array<Sight, kPictures> seen_;
  std::size_t count_ = 0;
  Eigen::Vector3d velocity_{0, 0, 0};
  double error_ = 0;
};

}  // namespace palpate
