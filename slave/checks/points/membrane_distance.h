// A flat membrane at rest must be at the scene's distance from the camera. Depths with a wrong
// scale (unit, baseline or focal length) show it nearer or farther.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "slave/checks/check.h"
#include "slave/checks/points/points_limits.h"
#include "slave/checks/points/points_sample.h"
#include "slave/scene/scene.h"
#include "slave/statistics/robust.h"

namespace palpate {

class MembraneDistanceCheck final : public Check<PointsSample> {
 public:
  // `X_SE`: the camera from which distances are measured. Only flat membranes are checked.
  MembraneDistanceCheck(const Scene& scene, const Eigen::Isometry3d& X_SE) : X_ES_(X_SE.inverse()) {
    if (std::holds_alternative<MembraneGeometry>(scene.object.geometry)) {
      X_EO_ = X_ES_ * scene.object.X_SO;
    }
  }

  // Compares the distance of the first surface that was measured at rest. Flags all points or none.
  void Examine(const PointsSample& sample, Findings* findings) noexcept override {
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
  void Reset() noexcept override { farther_.reset(); }

 private:
  Eigen::Isometry3d X_ES_;
  std::optional<Eigen::Isometry3d> X_EO_;  // of a flat membrane
  std::optional<double> farther_;          // difference from the scene's distance, relative [-]
};

}  // namespace palpate
