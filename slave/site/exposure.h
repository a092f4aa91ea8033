// What becomes of a seen world on its way into a camera: blur of the optics, light that falls
// across the picture and flickers, noise, rounding.
#pragma once

#include <array>
#include <cstdint>
#include <random>

#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"

namespace palpate::site {

// One camera, or two that expose at the same instants: the same light, noise of their own. The same
// sequence of calls gives the same pictures.
class Exposure {
 public:
  Exposure(const SiteOptions& options, const std::array<int, 2>& size);

  // Blurs `seen` (CV_32F) in place; beyond its edges it goes on as at them.
  void Blur(cv::Mat& seen) const;
  // The next instant: a flickering light has another strength.
  void Advance();
  // 8 bit grey of what is `seen` (CV_32F, the picture's size; blurred).
  cv::Mat Expose(const cv::Mat& seen);
  // How far blur reaches [px].
  [[nodiscard]] int reach() const { return reach_; }

 private:
  double blur_, flicker_;
  int reach_;
  float gain_ = 1;
  cv::Mat light_, noise_;  // CV_32F; noise larger than the picture: each takes a part of it
  std::mt19937 random_;
  std::uint64_t instants_ = 0;
};

}  // namespace palpate::site
