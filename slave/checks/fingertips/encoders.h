// The fingertip is where the manipulator's encoders report it: else its samples are of another
// time.
#pragma once

#include <algorithm>

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {

class FingerEncoderCheck final : public Check<ContactSample> {
 public:
  void Examine(const ContactSample& sample, Findings* findings) noexcept override {
    if (!sample.agrees_with_encoders) return;
    doubts_ = *sample.agrees_with_encoders ? std::max(doubts_ - 1, 0) : kForgives;
    if (doubts_ > 0) {
      findings->Fail(FailedCheck::kArm, "the fingertips are not where the encoders report them");
    }
    findings->Widen(sample.apart);
  }
  void Reset() noexcept override { doubts_ = 0; }

 private:
  // Samples after which it is forgiven: a network looks back as far [samples]. [tuned: late]
  static constexpr int kForgives = 15;
  int doubts_ = 0;
};

}  // namespace palpate
