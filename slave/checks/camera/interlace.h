// Odd and even rows show the same instant, at the tip.
#pragma once

#include <cstdlib>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"
#include "slave/vision/interlace_detector.h"

namespace palpate {

class InterlaceCheck final : public Check<CameraSample> {
 public:
  explicit InterlaceCheck(const cv::Mat& first) : detector_(first) {}

  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (std::abs(detector_.Shift(sample.image, sample.tip.p_I)) <= CameraLimits::kMostComb) return;
    findings->Fail(FailedCheck::kPicture, "odd and even rows show different instants");
  }

 private:
  InterlaceDetector detector_;
};

}  // namespace palpate
