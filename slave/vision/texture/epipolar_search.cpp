#include "slave/vision/texture/epipolar_search.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// The line of places, as pictures of the window's centre at the depth 1 / q.
class Line {
 public:
  Line(const Lens& from, const Lens& to, const Eigen::Isometry3d& X_TF, const WindowWarp& seen)
      : to_(to), X_TF_(X_TF), seen_(seen), centre_(RayOf(from, seen.p)) {
    constexpr double kArm = 4;  // [px]
    for (int k = 0; k < 2; ++k) arms_[k] = RayOf(from, seen.p + kArm * Eigen::Vector2d::Unit(k));
    arm_ = kArm;
  }
  [[nodiscard]] bool valid() const { return centre_ && arms_[0] && arms_[1]; }

  [[nodiscard]] std::optional<Eigen::Vector2d> At(double q) const { return Picture(*centre_, q); }
  // With the affine part of a piece of surface that faces the first camera.
  [[nodiscard]] std::optional<WindowWarp> WarpAt(double q) const {
    const auto p = At(q), x = Picture(*arms_[0], q), y = Picture(*arms_[1], q);
    if (!p || !x || !y) return std::nullopt;
    Eigen::Matrix2d A;
    A << (*x - *p) / arm_, (*y - *p) / arm_;
    return WindowWarp{A * seen_.A, *p};
  }

 private:
  [[nodiscard]] std::optional<Eigen::Vector2d> Picture(const Eigen::Vector2d& ray, double q) const {
    return Project(to_, X_TF_ * (ray.homogeneous() / q));
  }

  const Lens& to_;
  const Eigen::Isometry3d& X_TF_;
  const WindowWarp& seen_;
  std::optional<Eigen::Vector2d> centre_, arms_[2];
  double arm_ = 1;
};

struct Peak {
  double score = -1;
  WindowWarp warp;
};

}  // namespace

std::optional<WindowWarp> SearchEpipolar(const Lens& from, const Lens& to,
                                         const Eigen::Isometry3d& X_TF, const WindowWarp& seen,
                                         SsdTracker& tracker, std::size_t i,
                                         const EpipolarOptions& options) noexcept {
  const Line line(from, to, X_TF, seen);
  if (!line.valid()) return std::nullopt;
  const double q_near = 1 / options.near, q_far = 1 / options.far;
  const int level = std::min(1, tracker.picture().levels() - 1);
  // A picture's place is nearly linear in q: steps of about a pixel of the level.
  const double most_px = 1.0 * (1 << level);
  const auto first = line.At(q_far), last = line.At(q_near);
  constexpr int kMostSteps = 4000;
  const double length = first && last ? (*last - *first).norm() : most_px * kMostSteps;
  const int steps = static_cast<int>(std::clamp(length / most_px, 1.0, double{kMostSteps}));
  const double apart = 3 * most_px;  // another peak, not this one's slope

  // The best so far, and the best elsewhere; a peak that is overtaken from far away is the next
  // best elsewhere.
  Peak best;
  double elsewhere = -1;
  for (int k = 0; k <= steps; ++k) {
    const auto warp = line.WarpAt(q_far + (q_near - q_far) * k / steps);
    if (!warp) continue;
    const double score = tracker.Score(i, *warp, level);
    const bool same = best.score > -1 && (warp->p - best.warp.p).norm() <= apart;
    if (score > best.score) {
      if (!same) elsewhere = std::max(elsewhere, best.score);
      best = {score, *warp};
    } else if (!same) {
      elsewhere = std::max(elsewhere, score);
    }
  }
  const bool found =
      best.score >= options.least_correlation && best.score - elsewhere >= options.least_margin;
  return found ? std::optional(best.warp) : std::nullopt;
}

}  // namespace palpate
