#include "tests/slave/vision/texture/texture_pictures.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace palpate {

WavyTexture::WavyTexture(std::uint64_t seed) : random_(seed * 7919 + 1) {
  for (int k = 0; k < kWaves; ++k) {
    const double turn = random_.uniform(0.0, 2 * std::numbers::pi);
    const double length = random_.uniform(6.0, 40.0);  // [px]
    wave_.row(k) =
        2 * std::numbers::pi / length * Eigen::RowVector2d(std::cos(turn), std::sin(turn));
    phase_(k) = random_.uniform(0.0, 2 * std::numbers::pi);
  }
}

double WavyTexture::At(const Eigen::Vector2d& p) const {
  return 120 + 12 * ((wave_ * p + phase_).array().cos().sum());
}

cv::Mat WavyTexture::Picture(const WindowWarp& warp, double noise, double gain, double offset,
                             const cv::Size& size) {
  const Eigen::Matrix2d back = warp.A.inverse();
  cv::Mat picture(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double level = gain * At(back * (Eigen::Vector2d(x, y) - warp.p)) + offset;
      picture.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(level + (noise > 0 ? random_.gaussian(noise) : 0.0));
    }
  }
  return picture;
}

}  // namespace palpate
