// The points are as far apart along the plate as at rest.
#pragma once

#include "slave/checks/load/fit_sample.h"

namespace palpate {

class GrowthCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!sample.plate->grown) return;
    findings->Fail(FailedCheck::kScale,
                   "the distances of the points have changed since rest: zoom");
  }
};

}  // namespace palpate
