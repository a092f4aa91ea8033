// The load is within the range of its model.
#pragma once

#include "slave/checks/load/fit_sample.h"

namespace palpate {

class ModelRangeCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (sample.beyond_range.empty()) return;
    findings->Fail(FailedCheck::kModelRange, sample.beyond_range);
  }
};

}  // namespace palpate
