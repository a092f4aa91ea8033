#include "slave/mechanics/fem/signed_polar.h"

#include <Eigen/Eigenvalues>

namespace palpate::fem {

Eigen::Vector4d SignedPolarQuaternion(const Eigen::Matrix3d& F) noexcept {
  const double scale = F.cwiseAbs().maxCoeff();
  if (!(scale > 0) || !F.allFinite()) return {1, 0, 0, 0};
  const Eigen::Matrix3d B = F / scale;
  const Eigen::Vector3d axial(B(2, 1) - B(1, 2), B(0, 2) - B(2, 0), B(1, 0) - B(0, 1));
  Eigen::Matrix4d K;
  K(0, 0) = B.trace();
  K.block<1, 3>(0, 1) = axial.transpose();
  K.block<3, 1>(1, 0) = axial;
  K.block<3, 3>(1, 1) = B + B.transpose() - B.trace() * Eigen::Matrix3d::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(K);
  const Eigen::Vector4d q = eigen.eigenvectors().col(3);
  return q[0] < 0 ? Eigen::Vector4d(-q) : q;
}

}  // namespace palpate::fem
