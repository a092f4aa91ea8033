// The tip is where the manipulator's encoders report it.
#pragma once

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class EncoderCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (sample.agrees_with_encoders) return;
    findings->Fail(FailedCheck::kArm, "the tip is not where the encoders report it");
  }
};

}  // namespace palpate
