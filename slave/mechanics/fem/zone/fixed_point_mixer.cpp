#include "slave/mechanics/fem/zone/fixed_point_mixer.h"

#include <algorithm>

#include <Eigen/Cholesky>

namespace palpate {
namespace {

// Share of the Gram matrix's diagonal: steps that hardly differ do not count [-].
constexpr double kRegular = 1e-10;

}  // namespace

FixedPointMixer::FixedPointMixer(int size)
    : residual_steps_(size, kDepth), image_steps_(size, kDepth) {
  residual_ = last_residual_ = last_image_ = Eigen::VectorXd::Zero(size);
}

void FixedPointMixer::Advance(const Eigen::VectorXd& image, Eigen::VectorXd* x) noexcept {
  residual_ = image - *x;
  if (count_ > 0) {
    const int slot = (count_ - 1) % kDepth;
    residual_steps_.col(slot) = residual_ - last_residual_;
    image_steps_.col(slot) = image - last_image_;
  }
  last_residual_ = residual_;
  last_image_ = image;
  *x = image;
  const int steps = std::min(count_, kDepth);
  ++count_;
  if (steps == 0) return;
  Small gram(steps, steps);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kDepth, 1> share(steps);
  for (int i = 0; i < steps; ++i) {
    share[i] = residual_steps_.col(i).dot(residual_);
    for (int j = 0; j <= i; ++j) {
      gram(i, j) = gram(j, i) = residual_steps_.col(i).dot(residual_steps_.col(j));
    }
  }
  gram.diagonal() *= 1 + kRegular;
  const Eigen::LDLT<Small> factor(gram);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return;
  share = factor.solve(share).eval();
  if (!share.allFinite()) return;
  x->noalias() -= image_steps_.leftCols(steps) * share;
}

}  // namespace palpate
