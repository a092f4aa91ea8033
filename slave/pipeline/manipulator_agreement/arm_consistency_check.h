// Consistency of camera and encoders: their difference changes slowly, independent of their
// registration.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace palpate {

// Encoder reading of a manipulator that is visible in the image.
struct EncoderReading {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // [m]
  double lag = 0;                    // time between reading and image [periods of the images]
};

class ArmConsistencyCheck {
 public:
  // Returns whether both positions of one image agree, S [m]. `tolerance` [m]: error of the
  // measured tip; motion of the manipulator within the lag is allowed in addition.
  bool Agree(const Eigen::Vector3d& p_S_seen, const EncoderReading& reported,
             double tolerance) noexcept {
    const Eigen::Vector3d offset = p_S_seen - reported.p_S_tip;
    if (!offset_) offset_ = slow_offset_ = offset, p_S_reported_ = reported.p_S_tip;
    const double way = (reported.p_S_tip - p_S_reported_).norm();
    p_S_reported_ = reported.p_S_tip;
    parting_ = offset - slow_offset_;
    apart_ = (offset - *offset_).norm() - reported.lag * way;
    const bool agree = apart_ < tolerance;  // false for NaN
    if (agree) *offset_ += kFollow * (offset - *offset_);
    if (agree) slow_offset_ += kFollowSlowly * parting_;
    return agree;
  }
  void Reset() noexcept { offset_.reset(); }
  // Distance of both positions in the last image minus the distance that the lag explains [m]; may
  // be negative.
  [[nodiscard]] double apart() const { return apart_; }
  // Distance of both, S [m], beyond `noise` [m] of the cameras: images with undetected latency show
  // an earlier tip.
  [[nodiscard]] Eigen::Vector3d PartingBeyond(double noise) const noexcept {
    const double far = parting_.norm();
    if (!(far > noise)) return Eigen::Vector3d::Zero();
    return (1 - noise / far) * parting_;
  }

 private:
  // Weight of one image in the offset. [-] [tuned: ALagOfOneImageShowsAsAStepAlthoughBothAgree]
  static constexpr double kFollow = 0.03;
  // Weight of one image in the slow offset, which must not follow a lag. [-] [tuned:
  // ALagOfOneImageShowsAsAStepAlthoughBothAgree]
  static constexpr double kFollowSlowly = kFollow / 4;
  std::optional<Eigen::Vector3d> offset_;
  Eigen::Vector3d p_S_reported_{0, 0, 0};
  double apart_ = 0;
  Eigen::Vector3d slow_offset_{0, 0, 0}, parting_{0, 0, 0};
};

}  // namespace palpate
