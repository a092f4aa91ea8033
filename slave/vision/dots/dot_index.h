// The dots of one picture by place.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/vision/dots/dot.h"

namespace palpate {

class DotIndex {
 public:
  // Allocates only when there are more dots than ever before.
  void Build(std::span<const Dot> dots, std::span<const int> which);
  // The nearest of them to `place` within `reach` [px]; -1: none.
  [[nodiscard]] int Nearest(std::span<const Dot> dots, const Eigen::Vector2d& place,
                            double reach) const noexcept;

 private:
  static constexpr int kCells = 16;  // along each axis
  [[nodiscard]] int Cell(double offset) const noexcept;

  std::vector<int> heads_, next_;  // chains of dots per cell
  Eigen::Vector2d corner_{0, 0};
  double cell_ = 1;  // [px]
};

}  // namespace palpate
