// A load on the domed membrane explains the measured surface.
#pragma once

#include <algorithm>

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"

namespace palpate {

class DomeResidualCheck final : public Check<FitSample> {
 public:
  // `model_error`: of a point's displacement [m].
  explicit DomeResidualCheck(double model_error) : model_error_(model_error) {}

  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!(sample.off > std::max(2 * model_error_, LoadLimits::kTrueDent * sample.load.depth))) {
      return;
    }
    findings->Fail(FailedCheck::kMisfit, "no load on this membrane explains the measured surface");
  }

 private:
  double model_error_;
};

}  // namespace palpate
