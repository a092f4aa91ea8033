// The dots at rest are as far from each other, and where, the layout has them.
#pragma once

#include "slave/checks/check.h"
#include "slave/checks/points/points_limits.h"
#include "slave/checks/points/points_sample.h"

namespace palpate {

class DotsAtRestCheck final : public Check<PointsSample> {
 public:
  void Examine(const PointsSample& sample, Findings* findings) noexcept override {
    if (sample.seen.scale_error > PointsLimits::kTrueSize) {
      findings->Fail(FailedCheck::kScale,
                     "the distances of the dots differ from the layout: check the rig and the "
                     "layout");
    }
    if (sample.seen.place_error > PointsLimits::kTruePlace) {
      findings->Fail(FailedCheck::kRegistration,
                     "the positions of the dots differ from the layout: check the pose and the "
                     "layout");
    }
  }
};

}  // namespace palpate
