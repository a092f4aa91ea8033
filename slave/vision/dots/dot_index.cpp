#include "slave/vision/dots/dot_index.h"

#include <algorithm>
#include <cstddef>

namespace palpate {

void DotIndex::Build(std::span<const Dot> dots, std::span<const int> which) {
  heads_.assign(static_cast<std::size_t>(kCells * kCells), -1);
  next_.assign(dots.size(), -1);
  if (which.empty()) return;
  const auto at = [&](int dot) { return dots[static_cast<std::size_t>(dot)].centre; };
  Eigen::Vector2d low = at(which[0]), high = low;
  for (const int dot : which) {
    low = low.cwiseMin(at(dot));
    high = high.cwiseMax(at(dot));
  }
  corner_ = low;
  cell_ = std::max(1.0, (high - low).maxCoeff() / kCells);
  for (const int dot : which) {
    const Eigen::Vector2d offset = at(dot) - corner_;
    int& head = heads_[static_cast<std::size_t>(Cell(offset.y()) * kCells + Cell(offset.x()))];
    next_[static_cast<std::size_t>(dot)] = head;
    head = dot;
  }
}

int DotIndex::Cell(double offset) const noexcept {
  return static_cast<int>(std::clamp(offset / cell_, 0.0, kCells - 1.0));
}

int DotIndex::Nearest(std::span<const Dot> dots, const Eigen::Vector2d& place,
                      double reach) const noexcept {
  if (heads_.empty() || !place.allFinite() || !(reach >= 0)) return -1;
  const Eigen::Vector2d offset = place - corner_;
  int nearest = -1;
  double least = reach * reach;
  for (int j = Cell(offset.y() - reach); j <= Cell(offset.y() + reach); ++j) {
    for (int i = Cell(offset.x() - reach); i <= Cell(offset.x() + reach); ++i) {
      for (int dot = heads_[static_cast<std::size_t>(j * kCells + i)]; dot >= 0;
           dot = next_[static_cast<std::size_t>(dot)]) {
        const double distance = (dots[static_cast<std::size_t>(dot)].centre - place).squaredNorm();
        if (distance > least) continue;
        least = distance;
        nearest = dot;
      }
    }
  }
  return nearest;
}

}  // namespace palpate
