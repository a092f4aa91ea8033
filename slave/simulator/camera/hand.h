// A simulated person who holds the tool: tilt and tremor of the tool, and the changes of light.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"

namespace palpate::simulation {

// Every disturbance is a sum of two sines at frequencies that the seed draws; at time 0 the tool is
// straight and where the script has it, and the exposure is the usual one. Tremor of 8
// to 12 Hz: physiological tremor (Elble & Koller, Tremor, 1990).
class Hand {
 public:
  Hand(const SiteOptions::Hand& options, std::uint32_t seed);

  // Tilt of the tool, and displacement of its tip, at `t` [s].
  [[nodiscard]] double Tilt(double t) const noexcept;             // counter-clockwise in S [rad]
  [[nodiscard]] Eigen::Vector3d Offset(double t) const noexcept;  // of the tip, S [m]
  // Delay of the image of time `t` relative to the raster of images [intervals].
  [[nodiscard]] double Delay(double t) const noexcept;
  // Applies shadow and exposure to `seen` (CV_32F), in place.
  void Light(double t, cv::Mat* seen) const;

 private:
  // Between -1 and 1, 0 at time 0.
  struct Wave {
    std::array<double, 2> rate{};  // [Hz]
    double sign = 1;
    [[nodiscard]] double At(double t) const noexcept;
  };

  SiteOptions::Hand options_;
  Wave tilt_, tremor_x_, tremor_y_, drift_x_, drift_y_, exposure_, delay_;
  double shadow_heading_, shadow_period_;  // [rad], [s]
};

}  // namespace palpate::simulation
