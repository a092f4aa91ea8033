#include "slave/site/exposure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate::site {
namespace {

constexpr int kNoiseMargin = 256;        // of places where a picture's noise may begin [px]
constexpr double kFlickerPeriod = 41.3;  // [pictures]

// Brightest at the upper left, `fall` darker at the lower right.
cv::Mat Light(const cv::Size& size, double fall) {
  cv::Mat light(size, CV_32F);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double way = 0.5 * (x / (size.width - 1.0) + y / (size.height - 1.0));
      light.at<float>(y, x) = static_cast<float>(1 - fall * way);
    }
  }
  return light;
}

cv::Mat Noise(const cv::Size& size, double sigma, std::uint32_t seed) {
  cv::Mat noise(size.height + kNoiseMargin, size.width + kNoiseMargin, CV_32F, cv::Scalar(0));
  if (sigma > 0) cv::RNG(std::mt19937_64(seed)()).fill(noise, cv::RNG::NORMAL, 0, sigma);
  return noise;
}

}  // namespace

Exposure::Exposure(const SiteOptions& options, const std::array<int, 2>& size)
    : blur_(options.blur),
      flicker_(options.flicker),
      reach_(options.blur > 0 ? static_cast<int>(std::ceil(4 * options.blur)) : 0),
      light_(Light({size[0], size[1]}, options.lighting)),
      noise_(Noise({size[0], size[1]}, options.noise, options.seed + 2)),
      random_(options.seed) {}

void Exposure::Blur(cv::Mat& seen) const {
  if (reach_ == 0) return;
  cv::GaussianBlur(seen, seen, {2 * reach_ + 1, 2 * reach_ + 1}, blur_, blur_,
                   cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
}

void Exposure::Advance() {
  const double phase = 2 * std::numbers::pi * static_cast<double>(instants_++) / kFlickerPeriod;
  gain_ = static_cast<float>(1 + flicker_ * std::sin(phase));
}

cv::Mat Exposure::Expose(const cv::Mat& seen) {
  const int left = static_cast<int>(random_() % kNoiseMargin);
  const int top = static_cast<int>(random_() % kNoiseMargin);
  cv::Mat picture(seen.size(), CV_8U);
  for (int y = 0; y < seen.rows; ++y) {
    const auto* grey = seen.ptr<float>(y);
    const auto* light = light_.ptr<float>(y);
    const auto* noise = noise_.ptr<float>(y + top) + left;
    auto* out = picture.ptr<std::uint8_t>(y);
    for (int x = 0; x < seen.cols; ++x) {
      const float level = gain_ * light[x] * grey[x] + noise[x] + 0.5F;
      out[x] = static_cast<std::uint8_t>(std::clamp(level, 0.0F, 255.0F));
    }
  }
  return picture;
}

}  // namespace palpate::site
