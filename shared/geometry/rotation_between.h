#pragma once

#include <Eigen/Core>

namespace palpate {

// The rotation by the least angle that takes the direction of `a` to that of `b`, both other than
// zero. Of opposite ones: by half a turn about one of the axes across.
Eigen::Matrix3d RotationBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace palpate
