// One load explains the points of a volume within their noise.
#pragma once

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"

namespace palpate {

class ResidualCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!(sample.load.residual > LoadLimits::kGoodFit)) return;
    findings->Fail(FailedCheck::kMisfit,
                   "the residual of one load of this width exceeds the noise of the points");
  }
};

}  // namespace palpate
