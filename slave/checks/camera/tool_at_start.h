// The tool in the first image is the scene's, at the manipulator's home.
#pragma once

#include <cmath>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"
#include "slave/scene/scene.h"
#include "slave/vision/tool_end.h"

namespace palpate {

class ToolAtStartCheck final : public Check<CameraSample> {
 public:
  // `p_I_tip`: of the encoder reading [px]. `d_I`: direction of the tool; zero: unknown.
  // `width_px`: width in the scene.
  ToolAtStartCheck(const Scene& scene, const cv::Mat& first, const Eigen::Vector2d& p_I_tip,
                   const Eigen::Vector2d& d_I, double width_px) {
    if (!scene.sense.Find<TipTracking>()->template_file.empty() || d_I.isZero(0)) return;
    const Verdict elsewhere{Validity::kExtrapolated, FailedCheck::kArm,
                            "the tool is not at the manipulator's home in the first image"};
    const GreyFormat format(first);
    const auto seen = DetectToolEnd(first, format, p_I_tip, d_I, width_px);
    if (!seen) {
      if (ToolGoesOn(first, format, p_I_tip, d_I, width_px)) verdict_ = elsewhere;
      return;
    }
    const bool beyond = std::abs(seen->beyond) > CameraLimits::kToolElsewhere;
    const bool aside = std::abs(seen->aside) > CameraLimits::kToolElsewhere;
    const bool wide = std::abs(seen->width / width_px - 1) > CameraLimits::kToolWidth;
    if (beyond || (aside && !wide)) verdict_ = elsewhere;
    if (beyond || aside == wide) return;  // both: something covers a side of it
    if (wide) {
      verdict_ = {Validity::kExtrapolated, FailedCheck::kScale,
                  "the tool is not as wide as the scene's in the first image"};
    }
  }

  void Examine(const CameraSample& /*sample*/, Findings* findings) noexcept override {
    findings->verdict.Add(verdict_);
  }

 private:
  Verdict verdict_{Validity::kValid};
};

}  // namespace palpate
