// Images do not repeat bit for bit: with noise no camera takes one twice.
#pragma once

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"
#include "slave/checks/repeat_detector.h"

namespace palpate {

class FrozenImageCheck final : public Check<CameraSample> {
 public:
  // `noise`: of the first image [1/255 of full scale].
  explicit FrozenImageCheck(double noise)
      : detector_({.has_noise = noise > kLeastNoise, .parts = false}) {}

  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (detector_.Find(sample.image) != Repeat::kWhole) return;
    findings->Fail(FailedCheck::kFrozen, "the camera repeats the same image");
  }

 private:
  // Noise of a real camera [1/255 of full scale].
  static constexpr double kLeastNoise = 0.5;
  RepeatDetector detector_;
};

}  // namespace palpate
