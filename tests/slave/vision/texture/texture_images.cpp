#include "tests/slave/vision/texture/texture_images.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace palpate {
namespace {

constexpr double kMean = 120, kAmplitude = 12;  // levels

}  // namespace

WavyTexture::WavyTexture(std::uint64_t seed) : random_(seed * 7919 + 1) {
  for (int k = 0; k < kWaves; ++k) {
    const double turn = random_.uniform(0.0, 2 * std::numbers::pi);
    const double length = random_.uniform(6.0, 40.0);  // [px]
    wave_.row(k) =
        2 * std::numbers::pi / length * Eigen::RowVector2d(std::cos(turn), std::sin(turn));
    phase_(k) = random_.uniform(0.0, 2 * std::numbers::pi);
  }
}

cv::Mat WavyTexture::Image(const PatchWarp& warp, double noise, double gain, double offset,
                           const cv::Size& size) {
  // cos(kx x + (ky y + phase)), the factors of columns and rows are each computed once.
  const Eigen::Matrix<double, kWaves, 2> k = wave_ * warp.A.inverse();
  const Eigen::Matrix<double, kWaves, 1> phase = phase_ - k * warp.p;
  const Eigen::RowVectorXd xs = Eigen::RowVectorXd::LinSpaced(size.width, 0, size.width - 1);
  const Eigen::RowVectorXd ys = Eigen::RowVectorXd::LinSpaced(size.height, 0, size.height - 1);
  const Eigen::MatrixXd across = k.col(0) * xs;
  const Eigen::MatrixXd down = (k.col(1) * ys).colwise() + phase;
  const Eigen::MatrixXd cosines =
      down.array().cos().matrix().transpose() * across.array().cos().matrix() -
      down.array().sin().matrix().transpose() * across.array().sin().matrix();
  cv::Mat image(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double level = gain * (kMean + kAmplitude * cosines(y, x)) + offset;
      image.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(level + (noise > 0 ? random_.gaussian(noise) : 0.0));
    }
  }
  return image;
}

}  // namespace palpate
