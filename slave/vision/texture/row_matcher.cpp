#include "slave/vision/texture/row_matcher.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "slave/vision/texture/picture_pyramid.h"
#include "slave/vision/texture/window_template.h"

namespace palpate {
namespace {

void Check(const RowMatchOptions& options, const cv::Mat& left, const cv::Mat& right) {
  if (left.size() != right.size()) {
    throw std::invalid_argument("left and right picture differ in size");
  }
  if (options.least > options.most || options.most - options.least > 4096) {
    throw std::invalid_argument("disparities " + std::to_string(options.least) + " to " +
                                std::to_string(options.most) +
                                " px: accepted is least <= most, at most 4096 apart");
  }
}

struct Best {
  int shift = 0;
  double score = -1, elsewhere = -1;
};

// Places centre + shift of the row, first <= shift <= last.
Best Scan(WindowTemplate& window, const cv::Mat& grey, const Eigen::Vector2d& centre, int first,
          int last, std::vector<double>& scores) {
  Best best;
  scores.clear();
  for (int shift = first; shift <= last; ++shift) {
    scores.push_back(
        window.Score(grey, {Eigen::Matrix2d::Identity(), centre + Eigen::Vector2d(shift, 0)}));
    if (scores.back() > best.score) best = {shift, scores.back(), -1};
  }
  constexpr int kApart = 3;  // another peak, not this one's slope [px]
  for (int shift = first; shift <= last; ++shift) {
    const double score = scores[static_cast<std::size_t>(shift - first)];
    if (std::abs(shift - best.shift) >= kApart) best.elsewhere = std::max(best.elsewhere, score);
  }
  return best;
}

}  // namespace

std::vector<RowMatch> MatchRows(const cv::Mat& left, const cv::Mat& right,
                                const std::vector<Eigen::Vector2d>& at,
                                const RowMatchOptions& options) {
  Check(options, left, right);
  const PicturePyramid left_grey(left, 1), right_grey(right, 1);
  WindowTemplate forth(options.window), back(options.window);
  std::vector<double> scores;
  std::vector<RowMatch> matches(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!forth.Cut(left_grey[0], {Eigen::Matrix2d::Identity(), at[i]})) continue;
    const Best there = Scan(forth, right_grey[0], at[i], -options.most, -options.least, scores);
    if (there.score < options.least_correlation ||
        there.score - there.elsewhere < options.least_margin) {
      continue;
    }
    const WindowWarp coarse{Eigen::Matrix2d::Identity(), at[i] + Eigen::Vector2d(there.shift, 0)};
    const auto fine = forth.Align(right_grey[0], coarse, WindowTemplate::Freedom::kAffine);
    const auto shift = forth.Align(right_grey[0], coarse, WindowTemplate::Freedom::kShift);
    const auto& match = fine.converged ? fine : shift;
    // Rectified: what left its row, or ran from the best whole pixel, found something else.
    const Eigen::Vector2d ran = match.warp.p - coarse.p;
    if (!match.converged || std::abs(ran.x()) > 1.5 || std::abs(ran.y()) > 1) continue;

    if (!back.Cut(right_grey[0], {Eigen::Matrix2d::Identity(), match.warp.p},
                  WindowTemplate::Freedom::kShift)) {
      continue;
    }
    const Eigen::Vector2d row(match.warp.p.x(), at[i].y());
    const Best home = Scan(back, left_grey[0], row, options.least, options.most, scores);
    if (std::abs(row.x() + home.shift - at[i].x()) > options.most_side_miss) continue;
    matches[i] = {true, at[i].x() - match.warp.p.x(), match.correlation};
  }
  return matches;
}

}  // namespace palpate
