#include "slave/vision/texture/epipolar_search.h"

#include <algorithm>

#include "slave/vision/texture/epipolar_line.h"

namespace palpate {
namespace {

// The window at the line's place, as a piece of surface that faces the first camera is seen.
std::optional<WindowWarp> WarpAt(const EpipolarLine& line, const WindowWarp& seen) noexcept {
  constexpr double kArm = 4;  // [px]
  if (!line.in_picture()) return std::nullopt;
  const auto x = line.Neighbour(seen.p + kArm * Eigen::Vector2d::UnitX());
  const auto y = line.Neighbour(seen.p + kArm * Eigen::Vector2d::UnitY());
  if (!x || !y) return std::nullopt;
  Eigen::Matrix2d A;
  A << (*x - *line.place()) / kArm, (*y - *line.place()) / kArm;
  return WindowWarp{A * seen.A, *line.place()};
}

struct Peak {
  double score = -1;
  WindowWarp warp;
};

}  // namespace

std::optional<WindowWarp> SearchEpipolar(const Lens& from, const Lens& to,
                                         const Eigen::Isometry3d& X_TF, const WindowWarp& seen,
                                         WindowTemplate& window, const PicturePyramid& picture,
                                         int level, const EpipolarOptions& options) noexcept {
  const double step = 1 << level;  // a pixel of the level
  const double apart = 3 * step;   // another peak, not this one's slope
  // The longest line crosses the picture; what it walks outside is bounded by the same.
  const int most_steps = 4 * (to.size[0] + to.size[1]);
  EpipolarLine line(from, to, X_TF, seen.p);

  // The best so far, and the best elsewhere; a peak that is overtaken from far away is the next
  // best elsewhere.
  Peak best;
  double elsewhere = -1;
  for (int k = 0; k < most_steps && line.Next(step); ++k) {
    const auto warp = WarpAt(line, seen);
    if (!warp) continue;
    const double score = window.Score(picture[level], warp->OnLevel(level));
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
