// A tool can only press; what pulls is seen the wrong way round.
#pragma once

#include "slave/checks/load/load_sample.h"

namespace palpate {

class PullCheck final : public Check<LoadSample> {
 public:
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    if (!(sample.load.force > sample.load.sigma_force)) return;
    findings->Fail(FailedCheck::kMisfit,
                   "the load pulls outward: check the sides (left, right), the rig and the "
                   "object's pose");
  }
};

}  // namespace palpate
