// Depth images of known surfaces with quantisation, noise that is equal within patches, and holes.
#pragma once

#include <functional>
#include <random>

#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "tests/support/normal_noise.h"

namespace palpate {

// 320 x 240, 0.1 mm a count, at the origin of S.
inline DepthImages TestDepthCamera() {
  DepthImages camera;
  camera.unit = 1e-4;
  camera.fx = 300;
  camera.fy = 310;
  camera.cx = 155;
  camera.cy = 122;
  camera.sigma = 0.08e-3;
  return camera;
}

struct DepthNoise {
  double sigma = 0;  // of a depth [m]
  int patch = 1;     // edge of the square of pixels with a common error
};

// `depth` [m] of the ray (x, y, 1); not finite: a hole.
inline cv::Mat DepthImage(const DepthImages& camera,
                          const std::function<double(double, double)>& depth, DepthNoise noise,
                          std::mt19937* random, int width = 320, int height = 240) {
  NormalNoise normal;
  const int patches = width / noise.patch + 1;
  std::vector<double> off(static_cast<std::size_t>(patches * (height / noise.patch + 1)));
  for (double& value : off) value = noise.sigma * normal(*random);
  cv::Mat image(height, width, CV_16UC1, cv::Scalar(0));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double z = depth((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      const double seen =
          z + off[static_cast<std::size_t>(v / noise.patch * patches + u / noise.patch)];
      if (std::isfinite(seen)) {
        image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(seen / camera.unit));
      }
    }
  }
  return image;
}

}  // namespace palpate
