#include "slave/study/shape/neighbourhood_shape.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace palpate::study {
namespace {

// The direction in which the neighbours spread least, towards the pupil.
Eigen::Vector3d Normal(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& p) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  return n.dot(p) > 0 ? Eigen::Vector3d(-n) : n;
}

}  // namespace

std::vector<NeighbourhoodShape> LookAround(std::span<const Eigen::Vector3d> points,
                                           const PointTree& tree, double radius) {
  std::vector<NeighbourhoodShape> around(points.size());
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    tree.Within(points[i], radius, &near);
    const auto n = static_cast<double>(near.size());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const std::size_t j : near) {
      const Eigen::Vector3d d = (points[j] - points[i]) / radius;
      sum += d;
      squares += d * d.transpose();
    }
    around[i].neighbours = near.size();
    if (near.size() < 3) continue;
    const Eigen::Vector3d centroid = sum / n;
    const Eigen::Vector3d normal = Normal(squares / n - centroid * centroid.transpose(), points[i]);
    around[i].before = centroid.dot(normal);
    around[i].beside = (centroid - around[i].before * normal).norm();
  }
  return around;
}

}  // namespace palpate::study
