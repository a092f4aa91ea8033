// Contacts are where the pose has the object. They begin and end at its surface: else the pose is
// wrong, or late.
#pragma once

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class PoseCheck final : public Check<FingertipSample> {
 public:
  // Depth of a contact that begins or ends; foam is felt from 1.7 mm on [m]. [tuned: object
  // elsewhere than told]
  static constexpr double kApart = 2.2e-3;

  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    if (!sample.misplaced.empty()) findings->Fail(FailedCheck::kPose, sample.misplaced);
    if (sample.is_beyond_model) {
      findings->Fail(FailedCheck::kModelRange, "the force is beyond the range of the model");
    }
    const std::optional<bool>& stirs = sample.tip.touch().stirs;
    if (!sample.depth || !stirs) return;
    const bool is_apart = *stirs ? *sample.depth < -kApart : *sample.depth > kApart;
    is_late_ = is_apart || (is_late_ && (*stirs || *sample.depth > 0));
    if (!is_late_) return;
    findings->Fail(FailedCheck::kPose,
                   "the contact begins or ends at another depth than the pose implies");
  }

 private:
  bool is_late_ = false;  // until the contact is over
};

}  // namespace palpate
