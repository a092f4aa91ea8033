// Nothing touches the fingertip while its baseline is measured: else that is wrong until it is
// measured again.
#pragma once

#include "slave/checks/fingertips/fingertip_checks.h"
#include "slave/checks/fingertips/pose.h"

namespace palpate {

class RestContactCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    if (sample.tip.pressure() < kBelowRest) {
      findings->Fail(FailedCheck::kRestDrift,
                     "the pressure is below its baseline: something touched the fingertip while "
                     "the baseline was measured");
    }
    if (!sample.depth) return;
    const bool begins = sample.tip.touch().takes_rest && !takes_rest_;
    takes_rest_ = sample.tip.touch().takes_rest;
    if (begins) was_inside_ = false;
    if (takes_rest_ && *sample.depth > PoseCheck::kApart) was_inside_ = true;
    if (!was_inside_) return;
    findings->Fail(FailedCheck::kRestDrift,
                   "the pose was inside the object while the baseline was taken");
  }

 private:
  // Pressure above its baseline; five real fingers: -2 after a contact [counts].
  static constexpr double kBelowRest = -8;
  bool takes_rest_ = false, was_inside_ = false;
};

}  // namespace palpate
