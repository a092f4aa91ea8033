// How good force estimates are (paper B, table I).
#pragma once

#include <span>

#include <Eigen/Core>

namespace palpate {

// Per axis, frame F.
struct ForceErrors {
  std::size_t count = 0;
  Eigen::Vector3d rmse{0, 0, 0};         // [N]
  Eigen::Vector3d smse{0, 0, 0};         // mean squared error / variance of what was measured;
                                         // NaN: that did not vary
  Eigen::Vector3d correlation{0, 0, 0};  // NaN: one of them did not vary
  Eigen::Vector3d peak{0, 0, 0};         // largest |measured| [N]
  Eigen::Vector3d at_peak{0, 0, 0};      // |error| at that instant [N]
  Eigen::Vector3d worst{0, 0, 0};        // largest |error| [N]
};

// `estimated` and `measured` are of the same length, [N]. Empty ones give count 0.
ForceErrors CompareForces(std::span<const Eigen::Vector3f> estimated,
                          std::span<const Eigen::Vector3f> measured);

}  // namespace palpate
