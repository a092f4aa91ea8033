// A flat texture of smooth noise, shifted and deformed by a known warp.
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

#include "slave/vision/patch_aligner.h"

namespace palpate {

inline PatchWarp Shifted(double x, double y) {
  return {Eigen::Matrix2d::Identity(), {x, y}};
}

// A sum of waves, which is defined between pixels as well, so that every image of it is exact.
class WavyTexture {
 public:
  explicit WavyTexture(std::uint64_t seed = 3);
  // About 120 +- 40 levels. Draws an image in which texture point x lies at A x + p, multiplied by
  // `gain`, plus `offset`, with white noise of `noise` levels.
  [[nodiscard]] cv::Mat Image(const PatchWarp& warp, double noise = 0, double gain = 1,
                              double offset = 0, const cv::Size& size = {320, 240});

 private:
  static constexpr int kWaves = 24;
  Eigen::Matrix<double, kWaves, 2> wave_;  // [rad/px]
  Eigen::Matrix<double, kWaves, 1> phase_;
  cv::RNG random_;
};

}  // namespace palpate
