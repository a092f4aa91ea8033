// Images of a pair or depth camera do not repeat.
#pragma once

#include "slave/checks/check.h"
#include "slave/checks/points/points_limits.h"
#include "slave/checks/points/points_sample.h"
#include "slave/checks/repeat_detector.h"

namespace palpate {

class FrozenSourceCheck final : public Check<PointsSample> {
 public:
  void Examine(const PointsSample& sample, Findings* findings) noexcept override {
    if (!detector_.Repeats(sample.left, sample.right)) return;
    findings->Fail(FailedCheck::kFrozen, "a camera repeats the same image: it is frozen");
  }

 private:
  RepeatDetector detector_{{.learning = PointsLimits::kLearning}};
};

}  // namespace palpate
