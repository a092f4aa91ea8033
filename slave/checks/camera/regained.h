// Tip and object were not lost a moment ago: what was just found again may be something else.
#pragma once

#include <algorithm>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class RegainedCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (left_ > 0) findings->Fail(FailedCheck::kTip, "tip or object was lost a moment ago");
    const bool is_seen = !sample.object || sample.is_broken || sample.object->known;
    left_ = sample.tip.found && is_seen ? std::max(0, left_ - 1) : kImages;
  }
  void Reset() noexcept override { left_ = 0; }

 private:
  // That must agree [images]. [tuned: a hand comes and stays]
  static constexpr int kImages = 3;
  int left_ = 0;  // images until a found tip is trusted again
};

}  // namespace palpate
