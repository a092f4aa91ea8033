// The fingertip is where the manipulator's encoders report it: else its samples are of another
// time.
#pragma once

#include <algorithm>

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class FingerEncoderCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* /*findings*/) noexcept override {
    if (!sample.encoder_error) return;
    sample.consistency->Add({FailedCheck::kArm,
                             "the fingertips are not where the encoders report them",
                             std::max(0.0, *sample.encoder_error), kSigma});
  }

 private:
  // Difference of fingertip and encoder pose, beyond what their lag explains [m]: a single sample
  // half a millimetre away fails. [tuned: late]
  static constexpr double kSigma = 7.5e-5;
};

}  // namespace palpate
