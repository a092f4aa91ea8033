// The checks of one camera.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"
#include "slave/scene/scene.h"
#include "slave/vision/tool_end.h"

namespace palpate {

// Measured in the first image: noise [1/255 of full scale], direction of the tool (zero: unknown),
// its size in the scene, and its tip by the encoders [px], if they report it.
struct FirstImage {
  const cv::Mat& image;
  double noise = 0;
  Eigen::Vector2d d_I{0, 0};
  ToolEndSize tool;
  std::optional<Eigen::Vector2d> p_I_tip;
};

Checks<CameraSample> MakeCameraChecks(const Scene& scene, const FirstImage& first);

}  // namespace palpate
