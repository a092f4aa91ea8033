#include "slave/site/texture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate::site {
namespace {

constexpr double kOne = 65536;  // 16.16 fixed point

// White noise, smoothed across the seam, with mean 0 and standard deviation 1.
cv::Mat SmoothNoise(std::uint32_t seed, double grain) {
  // Neighbouring seeds of cv::RNG itself resemble each other.
  cv::RNG random{std::mt19937_64{seed}()};
  cv::Mat noise(Texture::kSize, Texture::kSize, CV_32F);
  random.fill(noise, cv::RNG::NORMAL, 0, 1);
  const double sigma = std::clamp(grain / 2, 0.5, 40.0);
  const int border = static_cast<int>(std::ceil(4 * sigma));
  cv::Mat wide, smooth;
  cv::copyMakeBorder(noise, wide, border, border, border, border, cv::BORDER_WRAP);
  cv::GaussianBlur(wide, smooth, {}, sigma);
  cv::Mat tile = smooth({border, border, Texture::kSize, Texture::kSize}).clone();
  cv::Scalar mean, deviation;
  cv::meanStdDev(tile, mean, deviation);
  tile = (tile - mean[0]) / deviation[0];
  return tile;
}

// Whole texture periods do not matter, so far-away places stay exact.
std::uint32_t ToFixed(double texels) {
  const double wrapped = texels - Texture::kSize * std::floor(texels / Texture::kSize);
  return static_cast<std::uint32_t>(wrapped * kOne);
}

std::uint32_t StepToFixed(double texels) {
  return static_cast<std::uint32_t>(
      static_cast<std::int64_t>(std::clamp(texels, -1e4, 1e4) * kOne));
}

}  // namespace

Texture Texture::Speckle(std::uint32_t seed, double grain, float grey, float contrast) {
  Texture texture;
  texture.texels_ = SmoothNoise(seed, grain);
  texture.texels_.forEach<float>(
      [&](float& t, const int*) { t = grey + contrast * std::clamp(t / 2, -1.0F, 1.0F); });
  return texture;
}

Texture Texture::Blotches(std::uint32_t seed, double grain, float dark, float light) {
  Texture texture;
  texture.texels_ = SmoothNoise(seed, grain);
  texture.texels_.forEach<float>([&](float& t, const int*) {
    t = dark + (light - dark) * std::clamp(0.5F + 2 * t, 0.0F, 1.0F);
  });
  return texture;
}

inline float Texture::Sample(std::uint32_t u, std::uint32_t v) const {
  constexpr std::uint32_t kMask = kSize - 1;
  const auto* texels = texels_.ptr<float>();
  const float fu = static_cast<float>(u & 0xffff) * static_cast<float>(1 / kOne);
  const float fv = static_cast<float>(v & 0xffff) * static_cast<float>(1 / kOne);
  const std::uint32_t x0 = (u >> 16) & kMask, x1 = (x0 + 1) & kMask;
  const std::uint32_t y0 = ((v >> 16) & kMask) * kSize, y1 = (((v >> 16) + 1) & kMask) * kSize;
  const float above = texels[y0 + x0] + fu * (texels[y0 + x1] - texels[y0 + x0]);
  const float below = texels[y1 + x0] + fu * (texels[y1 + x1] - texels[y1 + x0]);
  return above + fv * (below - above);
}

void Texture::Fill(cv::Mat& canvas, const cv::Point& origin,
                   const std::array<Eigen::Vector2d, 3>& at,
                   const std::array<Eigen::Vector2d, 3>& from) const {
  const Eigen::Vector2d shift(origin.x, origin.y);
  const std::array<Eigen::Vector2d, 3> p{at[0] - shift, at[1] - shift, at[2] - shift};
  const double low = std::min({p[0].y(), p[1].y(), p[2].y()});
  const double high = std::max({p[0].y(), p[1].y(), p[2].y()});
  const int first = static_cast<int>(std::ceil(std::max(low, 0.0)));
  const int last = static_cast<int>(std::floor(std::min(high, canvas.rows - 1.0)));
  if (first > last) return;
  Eigen::Matrix2d to, texel;
  to << p[1] - p[0], p[2] - p[0];
  texel << from[1] - from[0], from[2] - from[0];
  const double twice = to(0, 0) * to(1, 1) - to(0, 1) * to(1, 0);
  if (std::abs(twice) < 1e-12) return;
  Eigen::Matrix2d inverse;
  inverse << to(1, 1), -to(0, 1), -to(1, 0), to(0, 0);
  const Eigen::Matrix2d step = texel * inverse / twice;  // texels per pixel
  const std::uint32_t du = StepToFixed(step(0, 0)), dv = StepToFixed(step(1, 0));
  for (int row = first; row <= last; ++row) {
    double left = std::numeric_limits<double>::infinity(), right = -left;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d &a = p[i], &b = p[(i + 1) % 3];
      if ((a.y() < row && b.y() < row) || (a.y() > row && b.y() > row) || a.y() == b.y()) continue;
      const double x = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      left = std::min(left, x);
      right = std::max(right, x);
    }
    const int x0 = static_cast<int>(std::ceil(std::clamp(left, 0.0, canvas.cols + 1.0) - 1e-9));
    const int x1 = static_cast<int>(std::floor(std::clamp(right, -1.0, canvas.cols - 1.0)));
    if (x0 > x1) continue;
    const Eigen::Vector2d start = from[0] + step * (Eigen::Vector2d(x0, row) - p[0]);
    std::uint32_t u = ToFixed(start.x()), v = ToFixed(start.y());
    auto* out = canvas.ptr<float>(row);
    for (int x = x0; x <= x1; ++x, u += du, v += dv) out[x] = Sample(u, v);
  }
}

}  // namespace palpate::site
