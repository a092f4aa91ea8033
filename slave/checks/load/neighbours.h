// Neighbouring points lie on both sides of the fitted plate.
#pragma once

#include "slave/checks/load/fit_sample.h"

namespace palpate {

class NeighboursCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!(sample.plate->cluster > 0)) return;
    findings->Fail(FailedCheck::kMisfit,
                   "neighbouring points deviate from the fitted shape to one side");
  }
};

}  // namespace palpate
