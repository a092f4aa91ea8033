#include "slave/mechanics/membrane/membrane_triangle.h"

namespace palpate {
namespace {

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

}  // namespace

MembraneTriangle::MembraneTriangle(const std::array<Eigen::Vector3d, 3>& p) : p_(p) {
  const Eigen::Vector3d twice_area = (p[1] - p[0]).cross(p[2] - p[0]);
  area_ = twice_area.norm() / 2;
  normal_ = twice_area.normalized();
  for (int k = 0; k < 3; ++k) {
    const auto next = static_cast<std::size_t>((k + 1) % 3);
    const auto last = static_cast<std::size_t>((k + 2) % 3);
    gradients_.col(k) = normal_.cross(p[last] - p[next]) / (2 * area_);
  }
}

TriangleMatrix MembraneTriangle::Elastic(double poisson_ratio) const {
  const double nu = poisson_ratio;
  Eigen::Matrix3d law;
  law << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  law /= 1 - nu * nu;
  const Eigen::Vector3d e1 = (p_[1] - p_[0]).normalized();
  const Eigen::Vector3d e2 = normal_.cross(e1);
  Eigen::Matrix<double, 3, 9> strain;
  for (int k = 0; k < 3; ++k) {
    const double d1 = gradients_.col(k).dot(e1);
    const double d2 = gradients_.col(k).dot(e2);
    strain.block<1, 3>(0, 3 * k) = d1 * e1.transpose();
    strain.block<1, 3>(1, 3 * k) = d2 * e2.transpose();
    strain.block<1, 3>(2, 3 * k) = d2 * e1.transpose() + d1 * e2.transpose();
  }
  return area_ * strain.transpose() * law * strain;
}

TriangleMatrix MembraneTriangle::Tension() const {
  TriangleMatrix k = TriangleMatrix::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double product = area_ * gradients_.col(i).dot(gradients_.col(j));
      k.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(product);
    }
  }
  return k;
}

TriangleMatrix MembraneTriangle::Volume() const {
  TriangleMatrix h = TriangleMatrix::Zero();
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    const int last = (i + 2) % 3;
    const Eigen::Matrix3d block = CrossMatrix(p_[static_cast<std::size_t>(last)]) / 6;
    h.block<3, 3>(3 * i, 3 * next) = -block;
    h.block<3, 3>(3 * next, 3 * i) = block;
  }
  return h;
}

}  // namespace palpate
