// Rendering for simulated images: textures on triangles, the coverage of pixels by polygons, and
// the camera's optics and noise.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "slave/scene/scene.h"

namespace palpate::simulation {

// A seamless speckle texture and triangles filled with it, which show the motion of a body's
// material.
class Texture {
 public:
  static constexpr int kSize = 512;  // texels along a side; a power of two

  // Smooth noise around `grey` with extremes near +-`contrast`, grains of about `grain` texels.
  static Texture Speckle(std::uint32_t seed, double grain, float grey, float contrast);
  // Blotches with the two grey levels `dark` and `light` and soft edges.
  static Texture Blotches(std::uint32_t seed, double grain, float dark, float light);

  // Fills the pixels of `canvas` (CV_32F) whose centres lie in the triangle `at` [px]; `from`:
  // positions of the corners on the texture [texels].
  void Fill(cv::Mat& canvas, const std::array<Eigen::Vector2d, 3>& at,
            const std::array<Eigen::Vector2d, 3>& from) const;
  // The facets of a surface that face the camera, clockwise in the image; nullopt: a corner that
  // is not seen, and no facet with it.
  void FillFacets(cv::Mat& canvas, const std::vector<std::array<int, 3>>& facets,
                  const std::vector<std::optional<Eigen::Vector2d>>& at,
                  const std::vector<Eigen::Vector2d>& from) const;

 private:
  [[nodiscard]] float Sample(std::uint32_t u, std::uint32_t v) const;  // 16.16 fixed point

  cv::Mat texels_;  // CV_32F, kSize x kSize
};

// Returns the exact fraction of each pixel of `window` that is covered by closed polygons [px]:
// CV_32F, 0 to 1. The method is that of font rasterisers, with signed areas accumulated along rows,
// so straight edges have subpixel accuracy. Pixel centres at integers; loops of the opposite
// orientation are holes.
cv::Mat CoverageOf(const std::vector<std::vector<Eigen::Vector2d>>& polygons,
                   const cv::Rect& window);

// Smallest window of whole pixels around `polygon`, grown by `margin` and cut to `size`.
cv::Rect WindowAround(const std::vector<Eigen::Vector2d>& polygon, int margin,
                      const cv::Size& size);

// Optics and noise of a camera: blur, light that decreases across the image and flickers, noise,
// rounding. For one camera, or for two with the same exposure times: the light is the same, the
// noise separate. The same sequence of calls gives the same images.
class Exposure {
 public:
  Exposure(const SiteOptions& options, const std::array<int, 2>& size);

  // Blurs `seen` (CV_32F) in place; its edge values continue outside.
  void Blur(cv::Mat& seen) const;
  // The next instant: a flickering light has another strength.
  void Advance();
  // 8 bit grey of `seen` (CV_32F, the image's size; blurred).
  cv::Mat Expose(const cv::Mat& seen);
  // Radius of the blur [px].
  [[nodiscard]] int reach() const { return reach_; }

 private:
  double blur_, flicker_;
  int reach_;
  float gain_ = 1;
  cv::Mat light_, noise_;  // CV_32F; noise larger than the image: each image uses a part of it
  std::mt19937 random_;
  std::uint64_t instants_ = 0;
};

}  // namespace palpate::simulation
