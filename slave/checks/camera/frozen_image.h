// Images do not repeat bit for bit: with noise no camera takes one twice.
#pragma once

#include <cstring>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class FrozenImageCheck final : public Check<CameraSample> {
 public:
  // `noise`: of the first image [1/255 of full scale].
  explicit FrozenImageCheck(double noise) : is_noisy_(noise > kLeastNoise) {}

  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    const cv::Mat& image = sample.image;
    const bool comparable = image.size() == last_.size() && image.type() == last_.type() &&
                            image.isContinuous() && last_.isContinuous();
    const bool same = comparable && !image.empty() && image.data != last_.data &&
                      std::memcmp(image.data, last_.data, image.total() * image.elemSize()) == 0;
    last_ = image;
    if (same && is_noisy_) {
      findings->Fail(FailedCheck::kFrozen, "the camera repeats the same image");
    }
  }

 private:
  // Noise of a real camera [1/255 of full scale]. [derived: less than half a level is constant]
  static constexpr double kLeastNoise = 0.5;
  bool is_noisy_;
  cv::Mat last_;  // shares the pixels
};

}  // namespace palpate
