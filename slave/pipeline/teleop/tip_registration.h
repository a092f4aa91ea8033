// The eyes and the manipulator's encoders disagree by a constant (camera mounting, tool length).
// Measured whenever the tool stands, so that the operator, the local model and the pictures share
// one frame S.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace palpate {

class TipRegistration {
 public:
  // `still`: smallest motion between two pictures that counts as motion [m], > 0.
  explicit TipRegistration(double still) : still_(still) {}

  // One picture's tip, as seen and as the encoders said when it was taken, S [m].
  void Add(const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_encoders) noexcept {
    if (last_encoders_ && (p_S_encoders - *last_encoders_).norm() < still_) {
      // A running mean at first, then a slow average: one noisy picture must not move the tool.
      count_ = count_ < kAverage ? count_ + 1 : kAverage;
      offset_ += (p_S_seen - p_S_encoders - offset_) / count_;
    }
    last_encoders_ = p_S_encoders;
  }
  // Eyes minus encoders, S [m]; zero until the tool has stood for two pictures.
  [[nodiscard]] const Eigen::Vector3d& offset() const { return offset_; }

 private:
  static constexpr double kAverage = 32;  // [pictures]
  double still_;
  double count_ = 0;
  std::optional<Eigen::Vector3d> last_encoders_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
};

}  // namespace palpate
