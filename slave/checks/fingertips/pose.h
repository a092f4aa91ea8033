// The contact is where the pose has the object, and within the range of its model.
#pragma once

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class PoseCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    if (!sample.misplaced.empty()) findings->Fail(FailedCheck::kPose, sample.misplaced);
    if (!sample.is_beyond_model) return;
    findings->Fail(FailedCheck::kModelRange, "the force is beyond the range of the model");
  }
};

}  // namespace palpate
