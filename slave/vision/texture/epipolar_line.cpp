#include "slave/vision/texture/epipolar_line.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr double kClosest = 20;  // [1/baselines] [derived: nearer than any lens focuses]
constexpr int kHalvings = 40;    // halvings of one step

// Returns the warp of the window at a position on the line, for a surface that faces the first
// camera.
std::optional<PatchWarp> WarpAt(const EpipolarLine& line, const PatchWarp& seen) noexcept {
  constexpr double kArm = 4;  // [px]
  if (!line.in_image()) return std::nullopt;
  const auto x = line.Neighbour(seen.p + kArm * Eigen::Vector2d::UnitX());
  const auto y = line.Neighbour(seen.p + kArm * Eigen::Vector2d::UnitY());
  if (!x || !y) return std::nullopt;
  Eigen::Matrix2d A;
  A << (*x - *line.place()) / kArm, (*y - *line.place()) / kArm;
  return PatchWarp{A * seen.A, *line.place()};
}

struct Peak {
  double score = -1;
  PatchWarp warp;
};

}  // namespace

EpipolarLine::EpipolarLine(const Lens& from, const Lens& to, const Eigen::Isometry3d& X_TF,
                           const Eigen::Vector2d& p_F) noexcept
    : from_(from),
      to_(to),
      R_TF_(X_TF.linear()),
      t_TF_(X_TF.translation().normalized()),
      ray_(RayOf(from, p_F)) {}

// Projects ray + q t, which is independent of the distance, so that infinity is possible.
std::optional<Eigen::Vector2d> EpipolarLine::Image(const Eigen::Vector2d& ray,
                                                   double q) const noexcept {
  return Project(to_, R_TF_ * ray.homogeneous() + q * t_TF_);
}

std::optional<Eigen::Vector2d> EpipolarLine::Neighbour(const Eigen::Vector2d& p_F) const noexcept {
  const auto ray = RayOf(from_, p_F);
  return ray ? Image(*ray, q_) : std::nullopt;
}

bool EpipolarLine::IsInside(const Eigen::Vector2d& p) const {
  return p.minCoeff() >= -0.5 && p.x() <= to_.size[0] - 0.5 && p.y() <= to_.size[1] - 0.5;
}

// Returns whether the whole image is behind the position, including its farthest corner.
// (Increasing distance would be sufficient for a straight line, but a bowed one returns over the
// edge.)
bool EpipolarLine::Leaves(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const Eigen::Vector2d way = to - from;
  const Eigen::Vector2d corner(way.x() > 0 ? to_.size[0] - 0.5 : -0.5,
                               way.y() > 0 ? to_.size[1] - 0.5 : -0.5);
  return !IsInside(to) && way.dot(corner - to) <= 0;
}

bool EpipolarLine::Next(double step) noexcept {
  if (!ray_) return false;
  if (dq_ == 0) {
    dq_ = step / std::max(to_.fx, to_.fy);
    place_ = Image(*ray_, 0);
    return true;
  }
  for (int k = 0; k < kHalvings; ++k) {
    const double q = q_ + dq_;
    if (!(q <= kClosest)) return false;
    const auto next = Image(*ray_, q);
    if (place_) {
      if (!next || Leaves(*place_, *next)) return false;
      const double moved = (*next - *place_).norm() / step;
      if (moved > 1.5) {
        dq_ /= 2;
        continue;
      }
      dq_ *= moved > 0.5 ? 1 / moved : 2;
    }
    q_ = q;
    place_ = next;
    return true;
  }
  return false;
}

std::optional<double> NearestInBoth(const StereoRig& rig) noexcept {
  EpipolarLine line(rig.left, rig.right, rig.X_RL, {rig.left.cx, rig.left.cy});
  constexpr int kMaxSteps = 100'000;
  double q = 0;
  for (int k = 0; k < kMaxSteps && line.Next(1); ++k) {
    if (line.in_image()) q = line.q();
  }
  return q > 0 ? std::optional(rig.baseline() / q) : std::nullopt;
}

std::optional<PatchWarp> SearchEpipolar(const Lens& from, const Lens& to,
                                        const Eigen::Isometry3d& X_TF, const PatchWarp& seen,
                                        PatchAligner& window, const cv::Mat& image, int level,
                                        const EpipolarOptions& options) noexcept {
  const double step = 1 << level;  // one pixel at this level
  const double apart = 3 * step;   // distance beyond which a peak counts as another one
  // The longest line crosses the image; its part outside has the same limit.
  const int max_steps = 4 * (to.size[0] + to.size[1]);
  EpipolarLine line(from, to, X_TF, seen.p);

  // The best peak so far, and the best one far from it. A peak that is surpassed by a distant one
  // becomes the second best.
  Peak best;
  double elsewhere = -1;
  for (int k = 0; k < max_steps && line.Next(step); ++k) {
    const auto warp = WarpAt(line, seen);
    if (!warp) continue;
    const double score = window.Score(image, warp->OnLevel(level));
    const bool same = best.score > -1 && (warp->p - best.warp.p).norm() <= apart;
    if (score > best.score) {
      if (!same) elsewhere = std::max(elsewhere, best.score);
      best = {score, *warp};
    } else if (!same) {
      elsewhere = std::max(elsewhere, score);
    }
  }
  const bool found =
      best.score >= options.min_correlation && best.score - elsewhere >= options.min_margin;
  return found ? std::optional(best.warp) : std::nullopt;
}

}  // namespace palpate
