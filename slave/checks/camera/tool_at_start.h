// The tool in the first image is the scene's, at the manipulator's home.
#pragma once

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"
#include "slave/scene/scene.h"

namespace palpate {

class ToolAtStartCheck final : public Check<CameraSample> {
 public:
  // `p_I_tip`: of the encoder reading [px]. `d_I`: direction of the tool; zero: unknown.
  // `width_px`: width in the scene.
  ToolAtStartCheck(const Scene& scene, const cv::Mat& first, const Eigen::Vector2d& p_I_tip,
                   const Eigen::Vector2d& d_I, double width_px);

  void Examine(const CameraSample& /*sample*/, Findings* findings) noexcept override {
    findings->verdict.Add(verdict_);
  }

 private:
  Verdict verdict_{Validity::kValid};
};

}  // namespace palpate
