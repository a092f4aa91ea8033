#include "shared/geometry/rotation_between.h"

#include <cmath>

#include <Eigen/Geometry>

namespace palpate {

Eigen::Matrix3d RotationBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d u = a.stableNormalized(), v = b.stableNormalized();
  const Eigen::Vector3d across = u.cross(v);
  const double sine = across.norm();
  const Eigen::Vector3d axis = sine > 0 ? Eigen::Vector3d(across / sine) : u.unitOrthogonal();
  return Eigen::AngleAxisd(std::atan2(sine, u.dot(v)), axis).toRotationMatrix();
}

}  // namespace palpate
