#pragma once

#include <Eigen/Core>

namespace palpate {

// The rotation by the smallest angle from the direction of `a` to that of `b`; neither may be zero.
// Opposite directions give a half turn about a perpendicular axis.
Eigen::Matrix3d RotationBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace palpate
