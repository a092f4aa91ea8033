// The domed membrane at rest has the scene's shape.
#pragma once

#include <cmath>
#include <utility>

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"
#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {

class DomeAtRestCheck final : public Check<FitSample> {
 public:
  explicit DomeAtRestCheck(Ellipsoid rest) : rest_(std::move(rest)) {}

  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    const double height = rest_.centre.z() + rest_.semi_axes(2, 2);
    double square = 0;
    int count = 0;
    for (const SurfacePoint& point : sample.points_O) {
      const Eigen::Vector3d& p = point.p_S_rest;
      const Eigen::Vector2d at = p.head<2>().cwiseQuotient(rest_.semi_axes.diagonal().head<2>());
      if (!p.allFinite() || at.norm() > kMostOfRim) continue;
      const double off = DistanceOutside(rest_, p);
      if (std::abs(off) > height) continue;  // before or behind the membrane: something else
      square += off * off;
      ++count;
    }
    if (count == 0 || std::sqrt(square / count) < LoadLimits::kTrueDome * height) return;
    findings->Fail(FailedCheck::kRestShape,
                   "the membrane at rest differs from the scene: check its size, pose and "
                   "inflation");
  }

 private:
  // Of the rim: what lies beyond may be its mount [-].
  static constexpr double kMostOfRim = 0.9;
  Ellipsoid rest_;
};

}  // namespace palpate
