#include "shared/geometry/rotation_between.h"

#include <cmath>

#include <Eigen/Geometry>

namespace palpate {

Eigen::Matrix3d RotationBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d u = a.stableNormalized(), v = b.stableNormalized();
  const Eigen::Vector3d across = u.cross(v);
  const double sine = across.norm();
  Eigen::Vector3d axis = across / (sine > 0 ? sine : 1);
  axis -= u.dot(axis) * u;  // of nearly opposite ones the product is rounding, along `u` maybe
  if (axis.squaredNorm() < 0.25) axis = u.unitOrthogonal();
  axis.normalize();
  return Eigen::AngleAxisd(std::atan2(sine, u.dot(v)), axis).toRotationMatrix();
}

}  // namespace palpate
