#include "slave/pipeline/load/grid_subsample.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr int kSquares = 11;  // across: the plate meets 109 of the 121

}  // namespace

const std::vector<int>& GridSubsample::Of(const std::vector<SurfacePoint>& points_O) {
  chosen_.clear();
  chosen_.reserve(points_O.size());
  for (std::size_t i = 0; i < points_O.size(); ++i) {
    if (points_O[i].p_S_rest.head<2>().norm() <= radius_) chosen_.push_back(static_cast<int>(i));
  }
  if (chosen_.size() <= kMost) return chosen_;
  squares_.assign(static_cast<std::size_t>(kSquares) * kSquares, {});
  for (const int i : chosen_) Add(points_O[static_cast<std::size_t>(i)], i);
  chosen_.clear();
  for (const Square& square : squares_) {
    if (square.has_points) chosen_.push_back(square.nearest);
  }
  return chosen_;
}

void GridSubsample::Add(const SurfacePoint& point, int index) {
  const Eigen::Vector2d at =
      (point.p_S_rest.head<2>() / radius_ + Eigen::Vector2d::Ones()) * (kSquares / 2.0);
  const int column = std::min(static_cast<int>(at.x()), kSquares - 1);
  const int row = std::min(static_cast<int>(at.y()), kSquares - 1);
  Square& square = squares_[static_cast<std::size_t>(row * kSquares + column)];
  square.has_points = true;
  if (!point.seen) return;
  const double distance = (at - Eigen::Vector2d(column + 0.5, row + 0.5)).squaredNorm();
  if (square.nearest != kNone && distance >= square.distance) return;
  square.nearest = index;
  square.distance = distance;
}

}  // namespace palpate
