// The points lie as near to the fitted plate as without contact, but for the error of its law.
#pragma once

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"

namespace palpate {

class ScatterCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    const double law = LoadLimits::kModelError * sample.plate->deepest;
    if (sample.plate->deepest > 0 &&
        sample.NoiseShare() < 1 / (LoadLimits::kClearly * LoadLimits::kClearly) &&
        sample.off * sample.off - sample.rest_square > law * law) {
      findings->Fail(FailedCheck::kMisfit,
                     "the points deviate from the fitted shape by more than at rest");
    }
  }
};

}  // namespace palpate
