// The load that explains measured points of a surface. Frame O.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "slave/checks/check.h"

namespace palpate {

// `Verdict`: of the fit and of its checks.
struct SurfaceLoad : Verdict {
  Eigen::Vector3d p_O{0, 0, 0};  // its centre, at rest [m]
  Eigen::Vector3d n_O{0, 0, 1};  // outward normal there
  double force = 0;              // along n_O, of the tool on the object [N]: negative pushes
  double depth = 0;              // of the surface under it, along -n_O [m]
  double sigma_force = 0;        // [N]
  double sigma_place = 0;        // the larger of the two along the surface [m]
  double residual = 0;           // rms of (measured - fitted) / sigma; about 1 if all is well

  void Take(const Findings& found) noexcept {
    Add(found.verdict);
    sigma_force = std::hypot(sigma_force, found.sigma_force);
  }
};

}  // namespace palpate
