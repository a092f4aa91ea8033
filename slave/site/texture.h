// Speckle that repeats without a seam, and triangles filled with it: what makes a painted body move
// visibly with its material.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate::site {

class Texture {
 public:
  static constexpr int kSize = 512;  // texels along a side; a power of two

  // Smooth noise around `grey` with extremes near +-`contrast`, grains of about `grain` texels.
  static Texture Speckle(std::uint32_t seed, double grain, float grey, float contrast);
  // Two-valued blotches of `dark` and `light` on soft edges.
  static Texture Blotches(std::uint32_t seed, double grain, float dark, float light);

  // Fills the pixels of `canvas` (CV_32F, its first pixel at `origin` of the picture) whose centres
  // lie in the triangle `at` [px]; `from`: the corners' places on the texture [texels].
  void Fill(cv::Mat& canvas, const cv::Point& origin, const std::array<Eigen::Vector2d, 3>& at,
            const std::array<Eigen::Vector2d, 3>& from) const;

 private:
  [[nodiscard]] float Sample(std::uint32_t u, std::uint32_t v) const;  // 16.16 fixed point

  cv::Mat texels_;  // CV_32F, kSize x kSize
};

}  // namespace palpate::site
