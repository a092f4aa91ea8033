#include "slave/mechanics/plate/fit/load_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::plate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr int kSearchRings = 5;

// Smallest part of a rim's motion that the others do not explain.
constexpr double kNoDirection = 1e-6;

}  // namespace

LoadSearch::LoadSearch(double load_radius, double farthest) {
  places_.push_back({{0, 0}, load_radius});
  for (int ring = 1; ring <= kSearchRings; ++ring) {
    const double r = farthest * (ring - 0.1) / kSearchRings;
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

// Orthogonalises by the Gram-Schmidt method.
void RimMotions::Span(std::span<const Eigen::Vector2d> places, std::span<const double> sigmas) {
  columns_.resize(static_cast<Eigen::Index>(places.size()), 3);
  for (std::size_t i = 0; i < places.size(); ++i) {
    columns_.row(static_cast<Eigen::Index>(i)) << 1 / sigmas[i], places[i].x() / sigmas[i],
        places[i].y() / sigmas[i];
  }
  motions_.setIdentity();
  for (int k = 0; k < 3; ++k) {
    const double size = columns_.col(k).norm();
    for (int j = 0; j < k; ++j) {
      const double share = columns_.col(j).dot(columns_.col(k));
      columns_.col(k) -= share * columns_.col(j);
      motions_.col(k) -= share * motions_.col(j);
    }
    const double left = columns_.col(k).norm();
    const double scale = left > kNoDirection * size ? 1 / left : 0;
    columns_.col(k) *= scale;
    motions_.col(k) *= scale;
  }
}

void RimMotions::LeaveOut(Eigen::VectorXd* values) const noexcept {
  for (int k = 0; k < 3; ++k) *values -= columns_.col(k).dot(*values) * columns_.col(k);
}

}  // namespace palpate::plate
