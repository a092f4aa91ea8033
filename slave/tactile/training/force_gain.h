// One number that fits a known network to another fingertip.
#pragma once

#include <span>

#include <Eigen/Core>

namespace palpate {

// The gain g that makes g fz_estimated closest to fz_measured, least squares through the origin.
// Throws std::invalid_argument: nothing to fit, not finite, or not positive (the force is that of
// the object on the fingertip, say).
double FitForceGain(std::span<const Eigen::Vector3f> estimated,
                    std::span<const Eigen::Vector3f> measured);

}  // namespace palpate
