#include "slave/mechanics/plate/fit/load_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::plate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr int kRings = 5;

}  // namespace

LoadSearch::LoadSearch(double load_radius, double farthest) {
  places_.push_back({{0, 0}, load_radius});
  for (int ring = 1; ring <= kRings; ++ring) {
    const double r = farthest * (ring - 0.1) / kRings;
    for (int i = 0; i < 6 * ring; ++i) {
      const double angle = std::numbers::pi * i / (3 * ring);
      places_.push_back({{r * std::cos(angle), r * std::sin(angle)}, load_radius});
    }
  }
  for (const Disc& place : places_) under_load_.push_back(Deflection(place, place.centre));
}

void LoadSearch::SetPoints(std::span<const Vector2d> points) {
  if (std::ranges::equal(points, points_)) return;
  points_.assign(points.begin(), points.end());
  shapes_.resize(static_cast<Index>(points.size()), static_cast<Index>(places_.size()));
  shape_.resize(shapes_.rows());
  for (Index k = 0; k < shapes_.cols(); ++k) {
    for (Index i = 0; i < shapes_.rows(); ++i) {
      shapes_(i, k) =
          Deflection(places_[static_cast<std::size_t>(k)], points_[static_cast<std::size_t>(i)]);
    }
  }
}

LoadSearch::Found LoadSearch::Best(const Eigen::VectorXd& values, const Eigen::VectorXd& weights,
                                   const Eigen::Matrix<double, Eigen::Dynamic, 3>* left_out,
                                   double farthest) noexcept {
  Found best;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    if (places_[k].centre.norm() > farthest) continue;
    shape_ = shapes_.col(static_cast<Index>(k)).cwiseProduct(weights);
    for (int c = 0; left_out != nullptr && c < 3; ++c) {
      shape_ -= left_out->col(c).dot(shape_) * left_out->col(c);
    }
    const double mixed = shape_.dot(values), square = shape_.squaredNorm();
    if (!(mixed * mixed > best.explained * square)) continue;
    best = {places_[k].centre, mixed / square * under_load_[k], mixed * mixed / square};
  }
  return best;
}

}  // namespace palpate::plate
