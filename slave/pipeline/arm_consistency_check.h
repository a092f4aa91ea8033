// The manipulator's word on where the tip is, as a second witness: what is seen minus what it says
// changes slowly, whatever the registration of the two.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace palpate {

// What a manipulator that the picture shows says of the tip.
struct EncoderReading {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // [m]
  double lag = 0;  // how far its instant may be from the picture's [periods of the pictures]
  bool is_of_picture = false;  // told for the picture's instant; else for when it is asked
};

class ArmConsistencyCheck {
 public:
  // Of one picture, S [m]. `tolerance` [m]: of what is seen; the arm's own motion within the lag is
  // allowed besides.
  bool Agree(const Eigen::Vector3d& p_S_seen, const EncoderReading& said,
             double tolerance) noexcept {
    const Eigen::Vector3d offset = p_S_seen - said.p_S_tip;
    if (!offset_) offset_ = slow_offset_ = offset, said_ = said.p_S_tip;
    const double way = (said.p_S_tip - said_).norm();
    said_ = said.p_S_tip;
    parting_ = offset - slow_offset_;
    apart_ = (offset - *offset_).norm() - said.lag * way;
    const bool agree = apart_ < tolerance;  // false for NaN
    if (agree) *offset_ += kFollow * (offset - *offset_);
    if (agree) slow_offset_ += kFollowSlowly * parting_;
    return agree;
  }
  void Reset() noexcept { offset_.reset(); }
  // How far both were apart in the last picture, beyond what the lag allows [m]; may be negative.
  [[nodiscard]] double apart() const { return apart_; }
  // How far both part, S [m], beyond `noise` [m] of the eyes: pictures that come late by less than
  // is noticed show the tip where it was.
  [[nodiscard]] Eigen::Vector3d PartingBeyond(double noise) const noexcept {
    const double far = parting_.norm();
    if (!(far > noise)) return Eigen::Vector3d::Zero();
    return (1 - noise / far) * parting_;
  }

 private:
  static constexpr double kFollow = 0.03;               // of the offset, per picture
  static constexpr double kFollowSlowly = kFollow / 4;  // lest a lag be taken for registration
  std::optional<Eigen::Vector3d> offset_;
  Eigen::Vector3d said_{0, 0, 0};
  double apart_ = 0;
  Eigen::Vector3d slow_offset_{0, 0, 0}, parting_{0, 0, 0};
};

}  // namespace palpate
