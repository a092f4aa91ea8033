// Where a window of texture lies in a picture: the pixel u of the window (from its centre) is at
// A u + p.
#pragma once

#include <Eigen/Core>

namespace palpate {

struct WindowWarp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d p{0, 0};  // the centre [px]; (0, 0) is the centre of the upper left pixel

  // The same window on a picture shrunk by two, `level` times over.
  [[nodiscard]] WindowWarp OnLevel(int level) const {
    const double scale = 1.0 / (1 << level);
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
  [[nodiscard]] WindowWarp FromLevel(int level) const {
    const double scale = 1 << level;
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
};

}  // namespace palpate
