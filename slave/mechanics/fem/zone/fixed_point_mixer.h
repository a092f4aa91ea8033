// Accelerates a fixed-point iteration x = g(x) by the last few steps (Anderson's mixing; Walker and
// Ni, SIAM J. Numer. Anal. 49, 2011): the next x is that combination of the images whose residual
// is least.
#pragma once

#include <array>

#include <Eigen/Core>

namespace palpate {

class FixedPointMixer {
 public:
  explicit FixedPointMixer(int size);

  // Forgets the steps.
  void Reset() { count_ = 0; }
  // `x` becomes the next point, where `image` is g(x). Does not allocate.
  void Advance(const Eigen::VectorXd& image, Eigen::VectorXd* x) noexcept;

 private:
  static constexpr int kDepth = 5;  // steps that count
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kDepth, kDepth>;

  int count_ = 0;  // steps so far
  Eigen::MatrixXd residual_steps_, image_steps_;
  Eigen::VectorXd residual_, last_residual_, last_image_;
};

}  // namespace palpate
