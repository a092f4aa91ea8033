// Most points agree on one load.
#pragma once

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"

namespace palpate {

class ContradictingPointsCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (sample.left_out <= LoadLimits::kMostLeftOut * sample.points) return;
    findings->Fail(FailedCheck::kMisfit, "more than a quarter of the points contradict the others");
  }
};

}  // namespace palpate
