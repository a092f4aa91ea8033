// Nothing hides the tip, unless its indentation is seen.
#pragma once

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class TipCoverCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (!sample.compares_edge() || !sample.object->known || sample.is_dent_confirmed()) return;
    if (sample.tip.covered > kCovered) {
      findings->Fail(FailedCheck::kTipCovered, "a part of the tip is hidden");
    }
  }

 private:
  // Hidden part of the tip's template [-].
  static constexpr double kCovered = 0.3;
};

}  // namespace palpate
