// Motion of the object since the first image, if the encoders distinguish it from camera motion.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"

namespace palpate {

// Extrapolates an object's position: a straight line through the last few images.
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
  // Error, of the velocity [-]. [tuned: WhatIsFeltAndWhatTravelsGoWithIt]
  static constexpr double kKnown = 0.5;
  // Slope of a parabola at its end relative to the errors of its ends. [-] [tuned:
  // WhatIsFeltAndWhatTravelsGoWithIt]
  static constexpr double kBends = 3;
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

// Decides whether camera or object moves: the object's edge shows both alike, the encoders
// distinguish them.
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
  static constexpr double kWay = 10e-3;  // path of the tip for a second estimate of the offset [m]
  // Of the motion. [-] [tuned: APressIntoItIsFeltAsDeepAsItIs]
  static constexpr double kMargin = 0.4;
  static constexpr int kSure = 3;  // consecutive images
  std::optional<Eigen::Vector3d> offset_, last_said_;
  bool objects_ = false, is_decided_ = false, last_ = false;
  int in_a_row_ = 0;
};

// Allocation-free. Frame S.
class MovingObject {
 public:
  // For one image [m]: the measured tip, and the tip relative to an object at rest; sigma of the
  // motion between both; `still`: smallest motion.
  void Update(Time at, const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_on_object,
              double sigma, double still, const EncoderReading& said) noexcept {
    owner_.Update(p_S_seen, p_S_on_object, said, still);
    motion_ = {};
    if (owner_.is_objects()) motion_.offset = p_S_seen - p_S_on_object;
    trend_.Add(at, motion_.offset, sigma);
    motion_.velocity = trend_.velocity();
    motion_.velocity_error = trend_.error();
  }
  // Zero if the camera moves, or if the tool position is unknown.
  [[nodiscard]] const SurfaceMotion& motion() const noexcept { return motion_; }
  void Reset() noexcept { *this = {}; }

 private:
  MotionDisambiguator owner_;
  MotionTrend trend_;
  SurfaceMotion motion_;
};

}  // namespace palpate
