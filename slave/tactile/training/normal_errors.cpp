#include "slave/tactile/training/normal_errors.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace palpate {
namespace {

using Normals = std::vector<Eigen::Vector3d>;

// The rotation with the least sum of |measured - R found|^2 (Kabsch 1976).
Eigen::Matrix3d BestRotation(const Normals& found, const Normals& measured) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < found.size(); ++k) sum += measured[k] * found[k].transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

double MedianAngle(const Normals& found, const Normals& measured, const Eigen::Matrix3d& R) {
  std::vector<double> angles;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Eigen::Vector3d n = R * found[k];
    angles.push_back(std::atan2(n.cross(measured[k]).norm(), n.dot(measured[k])));
  }
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::ranges::nth_element(angles, middle);
  return *middle;
}

}  // namespace

NormalErrors CompareNormals(const Localiser& localiser, std::span<const TactileSignals> changes,
                            std::span<const Eigen::Vector3d> normals_F) {
  Normals found, measured;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const TouchPlace place = localiser.Locate(changes[k], FingerReading{});
    if (!place.usable()) continue;
    found.push_back(place.n_F);
    measured.push_back(normals_F[k]);
  }
  NormalErrors errors;
  errors.found = found.size();
  if (found.empty()) return errors;
  errors.median = MedianAngle(found, measured, Eigen::Matrix3d::Identity());
  errors.aligned_median = MedianAngle(found, measured, BestRotation(found, measured));
  return errors;
}

}  // namespace palpate
