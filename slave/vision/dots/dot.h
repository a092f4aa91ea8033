// A dot as one picture shows it.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace palpate {

// Dark dots on a light ground, or light ones on a dark ground.
enum class DotTone : std::uint8_t { kDark, kLight };

// Pixels: (0, 0) is the centre of the upper left one.
struct Dot {
  Eigen::Vector2d centre{0, 0};                     // grey-weighted centroid [px]
  Eigen::Matrix2d shape = Eigen::Matrix2d::Zero();  // second moments; a disc has r^2 / 4 I [px^2]
  double area = 0;                                  // [px^2]
  double contrast = 0;                              // ground minus dot, or the reverse [levels]
  double sigma = 0;  // of the centroid, per axis, from the noise around the dot [px]
};

}  // namespace palpate
