// A load moves the domed membrane inward: it was not in contact while the rest shape was measured.
#pragma once

#include <cmath>
#include <utility>

#include "slave/checks/load/fit_sample.h"
#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {

class OutwardCheck final : public Check<FitSample> {
 public:
  explicit OutwardCheck(Ellipsoid rest) : rest_(std::move(rest)) {}

  // By fourth powers a dent counts more than the bulge that its air makes elsewhere.
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (sample.load.force == 0) return;
    double outward = 0, inward = 0;
    for (const SurfacePoint& point : sample.points_O) {
      if (!point.seen) continue;
      const Eigen::Vector3d n = (point.p_S_rest - rest_.centre).normalized();
      const double way = n.dot(point.p_S - point.p_S_rest), square = way * way;
      if (std::isfinite(way)) (way > 0 ? outward : inward) += square * square;
    }
    if (!(outward > inward)) return;
    findings->Fail(FailedCheck::kRestShape,
                   "the surface moves outward: it was in contact while the rest shape was "
                   "measured");
  }

 private:
  Ellipsoid rest_;
};

}  // namespace palpate
