// The manipulator's word on where the tip is, as a second witness: what is seen minus what it says
// changes slowly, whatever the registration of the two.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace palpate {

// What a manipulator that the picture shows says of the tip.
struct ArmWord {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // [m]
  double lag = 0;  // how far its instant may be from the picture's [periods of the pictures]
};

class ArmWatch {
 public:
  // Of one picture, S [m]. `tolerance` [m]: of what is seen; the arm's own motion within the lag is
  // allowed besides.
  bool Agree(const Eigen::Vector3d& p_S_seen, const ArmWord& said, double tolerance) noexcept {
    const Eigen::Vector3d offset = p_S_seen - said.p_S_tip;
    if (!offset_) offset_ = offset, said_ = said.p_S_tip;
    const double way = (said.p_S_tip - said_).norm();
    said_ = said.p_S_tip;
    apart_ = (offset - *offset_).norm() - said.lag * way;
    const bool agree = apart_ < tolerance;  // false for NaN
    if (agree) *offset_ += kFollow * (offset - *offset_);
    return agree;
  }
  void Reset() noexcept { offset_.reset(); }
  // How far both were apart in the last picture, beyond what the lag allows [m]; may be negative.
  [[nodiscard]] double apart() const { return apart_; }

 private:
  static constexpr double kFollow = 0.03;  // of the offset, per picture
  std::optional<Eigen::Vector3d> offset_;
  Eigen::Vector3d said_{0, 0, 0};
  double apart_ = 0;
};

}  // namespace palpate
