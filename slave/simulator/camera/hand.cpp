#include "slave/simulator/camera/hand.h"

#include <cmath>
#include <numbers>
#include <random>

#include <opencv2/core.hpp>

namespace palpate::simulation {
namespace {

// Separates these random numbers from others of the seed.
constexpr std::uint32_t kHandDraw = 0x6861;
constexpr double kDrift = 2;         // amplitude of the drift, in tremors
constexpr double kFirstShare = 0.6;  // of the first sine; the rest is the second's
// Shadow: half width relative to the image's diagonal, and start distance beside the image.
constexpr double kShadowWidth = 0.2, kShadowBeside = 1.1;
// The exposure notices the shadow late and compensates a part of it.
constexpr double kLag = 0.4, kCompensated = 0.5;  // [s], [-]

}  // namespace

double Hand::Wave::At(double t) const noexcept {
  const double turns = 2 * std::numbers::pi * t;
  return sign *
         (kFirstShare * std::sin(turns * rate[0]) + (1 - kFirstShare) * std::sin(turns * rate[1]));
}

Hand::Hand(const SiteOptions::Hand& options, std::uint32_t seed) : options_(options) {
  std::seed_seq sequence{seed, kHandDraw};
  std::mt19937 random(sequence);
  const auto between = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) + 0.5) / 4294967296.0;
  };
  const auto draw = [&](double slowest, double fastest, Wave* wave) {
    for (double& rate : wave->rate) rate = between(slowest, fastest);
    wave->sign = between(-1, 1) < 0 ? -1 : 1;
  };
  draw(0.1, 0.3, &tilt_);
  for (Wave* wave : {&tremor_x_, &tremor_y_}) draw(8, 12, wave);
  for (Wave* wave : {&drift_x_, &drift_y_}) draw(0.1, 0.3, wave);
  draw(0.2, 0.6, &exposure_);
  draw(4, 12, &delay_);
  shadow_heading_ = between(0, 2 * std::numbers::pi);
  shadow_period_ = between(2.5, 4);
}

double Hand::Tilt(double t) const noexcept {
  return options_.tilt * tilt_.At(t);
}

Eigen::Vector3d Hand::Offset(double t) const noexcept {
  const Eigen::Vector2d fast(tremor_x_.At(t), tremor_y_.At(t));
  const Eigen::Vector2d slow(drift_x_.At(t), drift_y_.At(t));
  const Eigen::Vector2d offset = options_.tremor * (fast + kDrift * slow);
  return {offset.x(), offset.y(), 0};
}

double Hand::Delay(double t) const noexcept {
  return options_.jitter * delay_.At(t);
}

void Hand::Light(double t, cv::Mat* seen) const {
  const double diagonal = std::hypot(seen->cols, seen->rows);
  // Position of the shadow's centre relative to the image's centre, in diagonals.
  const auto passed = [this](double at) {
    const double share = at / shadow_period_ - std::floor(at / shadow_period_);
    return kShadowBeside * (2 * share - 1);
  };
  const auto taken = [&](double way) {
    return options_.shadow * std::exp(-way * way / (2 * kShadowWidth * kShadowWidth));
  };
  const double noticed = options_.exposure > 0 ? kCompensated * taken(passed(t - kLag)) : 0;
  const double gain = 1 + options_.exposure * exposure_.At(t) + noticed;
  const double cosine = std::cos(shadow_heading_), sine = std::sin(shadow_heading_);
  const double middle = passed(t);
  for (int y = 0; y < seen->rows; ++y) {
    auto* row = seen->ptr<float>(y);
    for (int x = 0; x < seen->cols; ++x) {
      const double way =
          ((x - 0.5 * seen->cols) * cosine + (y - 0.5 * seen->rows) * sine) / diagonal - middle;
      row[x] *= static_cast<float>(gain * (1 - taken(way)));
    }
  }
}

}  // namespace palpate::simulation
