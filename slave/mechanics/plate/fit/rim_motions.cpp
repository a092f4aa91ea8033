#include "slave/mechanics/plate/fit/rim_motions.h"

namespace palpate::plate {
namespace {

constexpr double kNoDirection = 1e-6;  // share of a rim's motion that others do not explain

}  // namespace

// By Gram and Schmidt.
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
