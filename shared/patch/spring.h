// What of a stiffness is a spring that can be shown.
#pragma once

#include <Eigen/Core>

namespace palpate {

// The nearest stiffness to `K` that is a spring: symmetric, eigenvalues within 0 to `most` [N/m]. A
// K that is one comes back as it is. Finite in, finite out. Real-time safe.
Eigen::Matrix3d NearestSpring(const Eigen::Matrix3d& K, double most) noexcept;

}  // namespace palpate
