#include "slave/pipeline/points/membrane_distance.h"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "shared/statistics/robust.h"

namespace palpate {

MembraneDistance::MembraneDistance(const Scene& scene, const Eigen::Isometry3d& X_SE)
    : X_ES_(X_SE.inverse()) {
  if (std::holds_alternative<MembraneGeometry>(scene.object.geometry)) {
    X_EO_ = X_ES_ * scene.object.X_SO;
  }
}

void MembraneDistance::Check(SurfaceObservation* seen) {
  if (!X_EO_ || !seen->found) return;
  if (!farther_) {
    const Eigen::Vector3d n_E = X_EO_->linear().col(2);
    std::vector<double> ratios;
    for (const SurfacePoint& point : seen->points) {
      if (!point.seen) continue;  // it may have no rest yet
      ratios.push_back(n_E.dot(X_ES_ * point.p_S_rest) / n_E.dot(X_EO_->translation()));
    }
    if (ratios.empty()) return;
    farther_ = MedianOf(ratios) - 1;
  }
  seen->scale_error = std::abs(*farther_);
  if (seen->scale_error > kTrue) seen->Fail(FailedCheck::kScale, kElsewhere);
}

}  // namespace palpate
