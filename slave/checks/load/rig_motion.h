// Cameras and rim have moved no farther than is compensated.
#pragma once

#include "slave/checks/load/fit_sample.h"

namespace palpate {

class RigMotionCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!sample.plate->moved || sample.plate->put_right) return;
    findings->Fail(FailedCheck::kCameraMotion,
                   "the cameras or the membrane's rim have moved since the rest images");
  }
};

}  // namespace palpate
