#include "shared/patch/spring.h"

#include <Eigen/Eigenvalues>

namespace palpate {

Eigen::Matrix3d NearestSpring(const Eigen::Matrix3d& K, double most) noexcept {
  const Eigen::Matrix3d symmetric = 0.5 * (K + K.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> modes(symmetric);
  const Eigen::Vector3d& k = modes.eigenvalues();
  const double rounding = 1e-12 * k.cwiseAbs().maxCoeff();
  if (symmetric == K && k.minCoeff() >= -rounding && k.maxCoeff() <= most) return K;
  const Eigen::Vector3d kept = k.cwiseMax(0).cwiseMin(most);
  return modes.eigenvectors() * kept.asDiagonal() * modes.eigenvectors().transpose();
}

}  // namespace palpate
