// The stable part of a stiffness.
#pragma once

#include <Eigen/Core>

namespace palpate {

// The nearest symmetric stiffness to `K` with eigenvalues from 0 to `most` [N/m]. A `K` that
// fulfils this is returned unchanged. Finite input gives finite output. Real-time safe.
Eigen::Matrix3d NearestSpring(const Eigen::Matrix3d& K, double most) noexcept;

}  // namespace palpate
