// Sharpness and brightness are those of the first image, and the tip is known well enough for its
// indentation.
#pragma once

#include <algorithm>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class ImageQualityCheck final : public Check<CameraSample> {
 public:
  // Sigma from which on the tip is only roughly known [px].
  static constexpr double kRoughTip = 0.4;

  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (!sample.compares_edge() || !sample.object->known) return;
    const ObjectSighting& seen = *sample.object;
    const bool rough = sample.tip_sigma > std::max(kRoughTip, kRough * sample.dent_O.norm());
    const bool blurred = seen.sharpness < CameraLimits::kSharpness ||
                         seen.sharpness_at_rest < CameraLimits::kSharpAtRest;
    if (blurred || rough || seen.exposure > CameraLimits::kOverexposed) {
      findings->Fail(FailedCheck::kPicture,
                     "the image is blurred, overexposed or too noisy at the tip");
    }
  }

 private:
  // Sigma of the tip by the indentation [-].
  static constexpr double kRough = 0.12;
};

}  // namespace palpate
