// A domed membrane at rest has the scene's shape, and was not in contact while it was measured.
#pragma once

#include <cmath>
#include <utility>

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"
#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {

class DomeRestShapeCheck final : public Check<FitSample> {
 public:
  explicit DomeRestShapeCheck(Ellipsoid rest) : rest_(std::move(rest)) {}

  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (RmsOffset(sample) >= LoadLimits::kTrueDome * Height()) {
      findings->Fail(FailedCheck::kRestShape,
                     "the membrane at rest differs from the scene: check its size, pose and "
                     "inflation");
    }
    if (sample.load.force != 0 && MovesOutward(sample)) {
      findings->Fail(FailedCheck::kRestShape,
                     "the surface moves outward: it was in contact while the rest shape was "
                     "measured");
    }
  }

 private:
  // Points beyond this fraction of the rim's radius may belong to the mount [-]. [tuned:
  // domed_scene_test]
  static constexpr double kMaxOfRim = 0.9;

  [[nodiscard]] double Height() const noexcept { return rest_.centre.z() + rest_.semi_axes(2, 2); }
  // Returns the distance of the points at rest from the scene's shape [m]; points farther than its
  // height are another object's.
  [[nodiscard]] double RmsOffset(const FitSample& sample) const noexcept {
    double square = 0;
    int count = 0;
    for (const SurfacePoint& point : sample.points_O) {
      const Eigen::Vector3d& p = point.p_S_rest;
      const Eigen::Vector2d at = p.head<2>().cwiseQuotient(rest_.semi_axes.diagonal().head<2>());
      if (!p.allFinite() || at.norm() > kMaxOfRim) continue;
      const double offset = DistanceOutside(rest_, p);
      if (std::abs(offset) > Height()) continue;
      square += offset * offset;
      ++count;
    }
    return count > 0 ? std::sqrt(square / count) : 0;
  }
  // Weights displacements by their fourth power, so that an indentation counts more than the bulge
  // that the displaced air causes around it.
  [[nodiscard]] bool MovesOutward(const FitSample& sample) const noexcept {
    double outward = 0, inward = 0;
    for (const SurfacePoint& point : sample.points_O) {
      if (!point.seen) continue;
      const Eigen::Vector3d n = (point.p_S_rest - rest_.centre).normalized();
      const double displacement = n.dot(point.p_S - point.p_S_rest);
      if (!std::isfinite(displacement)) continue;
      (displacement > 0 ? outward : inward) += std::pow(displacement, 4);
    }
    return outward > inward;
  }

  Ellipsoid rest_;
};

}  // namespace palpate
