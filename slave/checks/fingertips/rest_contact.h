// Nothing touches the fingertip while its baseline is measured: else that is wrong until it is
// measured again.
#pragma once

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class RestContactCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    if (sample.tip.pressure() < kBelowBaseline) {
      findings->Fail(FailedCheck::kRestDrift,
                     "the pressure is below its baseline: something touched the fingertip while "
                     "the baseline was measured");
    }
    const bool is_baseline = sample.tip.touch().is_baseline;
    if (is_baseline && !was_baseline_) was_inside_ = false;
    was_baseline_ = is_baseline;
    if (is_baseline && sample.depth && *sample.depth > kInside) was_inside_ = true;
    if (!was_inside_) return;
    findings->Fail(FailedCheck::kRestDrift,
                   "the pose was inside the object while the baseline was taken");
  }

 private:
  // Pressure above its baseline; five real fingers: -2 after a contact [counts].
  static constexpr double kBelowBaseline = -8;
  // Depth of a pose that is inside the object; foam raises the pressure from 1.7 mm on [m]. [tuned:
  // RestValuesTakenInsideTheObjectAreDoubtedUntilTakenAnew]
  static constexpr double kInside = 2.2e-3;
  bool was_baseline_ = false, was_inside_ = false;
};

}  // namespace palpate
