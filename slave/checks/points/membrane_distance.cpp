#include "slave/checks/points/membrane_distance.h"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "shared/statistics/robust.h"
#include "slave/checks/points/points_limits.h"

namespace palpate {

MembraneDistanceCheck::MembraneDistanceCheck(const Scene& scene, const Eigen::Isometry3d& X_SE)
    : X_ES_(X_SE.inverse()) {
  if (std::holds_alternative<MembraneGeometry>(scene.object.geometry)) {
    X_EO_ = X_ES_ * scene.object.X_SO;
  }
}

void MembraneDistanceCheck::Examine(const PointsSample& sample, Findings* findings) noexcept {
  if (!X_EO_ || !sample.seen.found) return;
  if (!farther_) {
    const Eigen::Vector3d n_E = X_EO_->linear().col(2);
    std::vector<double> ratios;
    for (const SurfacePoint& point : sample.seen.points) {
      if (!point.seen) continue;  // it may have no rest yet
      ratios.push_back(n_E.dot(X_ES_ * point.p_S_rest) / n_E.dot(X_EO_->translation()));
    }
    if (ratios.empty()) return;
    farther_ = MedianOf(ratios) - 1;
  }
  sample.seen.scale_error = std::abs(*farther_);
  if (sample.seen.scale_error > PointsLimits::kTrueSize) {
    findings->Fail(FailedCheck::kScale,
                   "the membrane at rest is nearer or farther than in the scene: check unit, "
                   "baseline, fx, fy and the poses");
  }
}

}  // namespace palpate
