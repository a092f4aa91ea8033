// Forces sampled at the image rate, shown at the haptic rate: delayed by one sample period and
// interpolated linearly over their time stamps (paper A, 3.4, below eq. 7; after Zhuang & Canny
// 2000).
//
//   F(t) = linear through (s_k, F_k) at t - D,   D = newest period + transport delay
//
// The transport delay is the largest arrival - stamp of late: raised at once, lowered slowly, so
// that jitter neither stalls nor hurries the hand. A sample without predecessor is held.
// Exact for constants; a ramp lags by exactly D (reference f, interpolation_60_to_1000).
#pragma once

#include <array>

#include <Eigen/Core>

namespace palpate {

class DelayedLinear {
 public:
  // A sample with its `stamp` [s] and when it came, `arrival` >= `stamp` [s], both on the reader's
  // clock. Stamps that do not rise are ignored. Real-time safe.
  void Add(double stamp, double arrival, const Eigen::Vector3d& force) noexcept;
  // Zero before the first sample. Real-time safe.
  [[nodiscard]] Eigen::Vector3d At(double now) const noexcept;
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  // Newest sample [N]; zero before the first.
  [[nodiscard]] const Eigen::Vector3d& newest() const noexcept { return samples_[0].force; }
  void Clear() noexcept { *this = DelayedLinear(); }

 private:
  struct Sample {
    double stamp = 0;
    Eigen::Vector3d force{0, 0, 0};
  };
  static constexpr int kKept = 8;
  std::array<Sample, kKept> samples_{};  // newest first
  int count_ = 0;
  double transport_ = 0;  // [s]
};

}  // namespace palpate
