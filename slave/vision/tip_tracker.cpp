#include "slave/vision/tip_tracker.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <opencv2/core.hpp>

namespace palpate {
namespace {

constexpr int kSamePeak = 2;            // places this near to the best belong to it [px]
constexpr double kAsGood = 0.01;        // a second peak within this score of the best is its equal
constexpr std::size_t kCandidates = 6;  // of the coarse search, looked at closely
constexpr double kMostCovered = 0.65;   // of the template
// Where the tip may be anywhere: another bar fits a template along half its length. Without noise
// so much more than min_score, and so little covered.
constexpr double kReacquired = 0.3, kCoveredAgain = 0.15;
constexpr int kLeastCoarse = 7;  // edge below which a shrunk template tells too little [px]

struct Peak {
  cv::Point at;
  double score = -1;
};

Peak BestOf(const ScoreMap& map) {
  Peak best;
  cv::minMaxLoc(map, nullptr, &best.score, nullptr, &best.at);
  return best;
}

bool IsLocalPeak(const ScoreMap& map, int x, int y) {
  const double score = map(y, x);
  for (int j = std::max(0, y - 1); j <= std::min(map.rows - 1, y + 1); ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(map.cols - 1, x + 1); ++i) {
      if (map(j, i) > score) return false;
    }
  }
  return true;
}

bool HasEqual(const ScoreMap& map, const Peak& best) {
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      if (map(y, x) < best.score - kAsGood) continue;
      const bool near =
          std::abs(x - best.at.x) <= kSamePeak && std::abs(y - best.at.y) <= kSamePeak;
      if (!near && IsLocalPeak(map, x, y)) return true;
    }
  }
  return false;
}

bool OnBorder(const ScoreMap& map, const cv::Point& at) {
  return at.x == 0 || at.y == 0 || at.x == map.cols - 1 || at.y == map.rows - 1;
}

Ncc MakeNcc(const TipTemplate& tip, const GreyFormat& format) {
  const cv::Size size = format.size();
  if (tip.pixels.width > size.width || tip.pixels.height > size.height) {
    throw std::runtime_error("the tip's template (" + std::to_string(tip.pixels.width) + " x " +
                             std::to_string(tip.pixels.height) + " px) is larger than the image (" +
                             std::to_string(size.width) + " x " + std::to_string(size.height) +
                             " px)");
  }
  return Ncc(tip.pixels);
}

// From the middle of what the alignment goes by, each pixel by its gradient, to the anchor.
Eigen::Vector2d LeverOf(const TipTemplate& tip) {
  const GreyPatch& pixels = tip.pixels;
  Eigen::Vector2d sum(0, 0);
  double weight = 0;
  for (int y = 1; y + 1 < pixels.height; ++y) {
    for (int x = 1; x + 1 < pixels.width; ++x) {
      const Eigen::Vector2d gradient(pixels.At(x + 1, y) - pixels.At(x - 1, y),
                                     pixels.At(x, y + 1) - pixels.At(x, y - 1));
      const double w =
          tip.weights[static_cast<std::size_t>(y * pixels.width + x)] * gradient.squaredNorm();
      sum += w * Eigen::Vector2d(x, y);
      weight += w;
    }
  }
  return weight > 0 ? Eigen::Vector2d(tip.anchor - sum / weight) : Eigen::Vector2d(0, 0);
}

}  // namespace

TipTracker::TipTracker(const TipTemplate& tip, const GreyFormat& format, const Options& options,
                       std::optional<Eigen::Vector2d> start_I)
    : format_(format),
      options_(options),
      template_(tip),
      lever_(LeverOf(tip)),
      ncc_(MakeNcc(tip, format)),
      aligner_(tip.Aligner()),
      last_(start_I) {
  const int edge = std::min(tip.pixels.width, tip.pixels.height);
  for (shrink_ = 4; shrink_ > 1 && edge / shrink_ < kLeastCoarse; shrink_ /= 2) {
  }
  for (; !coarse_; shrink_ /= 2) {
    GreyPatch pattern;
    Shrink(tip.pixels, shrink_, pattern);
    try {
      coarse_.emplace(pattern);
    } catch (const std::invalid_argument&) {
      if (shrink_ == 1) throw;
      continue;  // shrunk, it has lost its contrast
    }
    break;
  }
  candidates_.reserve(kCandidates);
}

Eigen::Vector2d TipTracker::Predicted() const {
  const Eigen::Vector2d image(format_.size().width - 1, format_.size().height - 1);
  return (*last_ + step_).cwiseMax(0).cwiseMin(image);
}

cv::Rect TipTracker::WindowAround(const Eigen::Vector2d& tip, double scale) const {
  const GreyPatch& pattern = ncc_.pattern();
  const auto edge = [&](int pattern_edge) {
    const int least = pattern_edge + 2 * kReach;
    return static_cast<int>(scale * std::max(options_.roi, least));
  };
  const cv::Size size(edge(pattern.width), edge(pattern.height));
  const Eigen::Vector2d centre =
      tip - template_.anchor + 0.5 * Eigen::Vector2d(pattern.width - 1, pattern.height - 1);
  const cv::Point corner(static_cast<int>(std::lround(centre.x())) - size.width / 2,
                         static_cast<int>(std::lround(centre.y())) - size.height / 2);
  return cv::Rect(corner, size) & cv::Rect(cv::Point(), format_.size());
}

cv::Rect TipTracker::search_window() const {
  return last_ ? WindowAround(Predicted(), 1) : cv::Rect(cv::Point(), format_.size());
}

TipObservation TipTracker::Track(const cv::Mat& image) {
  Match match;
  if (last_) {
    match = SearchWindow(image, WindowAround(Predicted(), 1));
    if (match.on_border) match = SearchWindow(image, WindowAround(Predicted(), 2));
  }
  if (!match.tip.found) match.tip = SearchPicture(image);
  if (!match.tip.found) {
    last_.reset();
    return match.tip;
  }
  step_ = last_ && !match.tip.reacquired ? (match.tip.p_I - *last_).eval() : Eigen::Vector2d(0, 0);
  last_ = match.tip.p_I;
  match.tip.lever = lever_;
  return match.tip;
}

TipTracker::Match TipTracker::SearchWindow(const cv::Mat& image, const cv::Rect& window) {
  Match match;
  format_.Read(image, window, window_);
  const ScoreMap& map = ncc_.Match(window_);
  if (map.empty()) return match;
  const Peak best = BestOf(map);
  match.tip.score = best.score;
  match.on_border = best.score >= options_.min_score && OnBorder(map, best.at);
  const bool is_unique = best.score >= options_.min_score && !HasEqual(map, best);
  if (is_unique && !match.on_border) match.tip = Measure(best.score, window, best.at);
  return match;
}

TipObservation TipTracker::Measure(double score, const cv::Rect& window, const cv::Point& peak) {
  constexpr double kCoarse = 0.5;  // of a peak of whole pixels, at worst [px]
  const Eigen::Vector2d start = template_.Centre(peak);
  const PatchAligner::Match fine =
      aligner_.AlignRobustly(window_.Mat(), {Eigen::Matrix2d::Identity(), start});
  const Eigen::Vector2d p = fine.converged ? (fine.warp.p - start).eval() : Eigen::Vector2d(0, 0);
  TipObservation tip;
  tip.found = fine.covered < kMostCovered;
  tip.score = score;
  tip.p_I = p + template_.anchor + Eigen::Vector2d(window.x + peak.x, window.y + peak.y);
  tip.covered = fine.covered;
  tip.aligned = fine.converged;
  tip.sigma = fine.converged ? std::sqrt(fine.covariance.diagonal().maxCoeff()) : kCoarse;
  return tip;
}

TipObservation TipTracker::SearchPicture(const cv::Mat& image) {
  FindCandidates(image);
  const GreyPatch& pattern = ncc_.pattern();
  const int margin = 2 * shrink_ + 2;
  TipObservation best, second;
  for (const Candidate& candidate : candidates_) {
    const cv::Rect window(candidate.corner.x - margin, candidate.corner.y - margin,
                          pattern.width + 2 * margin, pattern.height + 2 * margin);
    TipObservation tip = SearchWindow(image, window & cv::Rect(cv::Point(), format_.size())).tip;
    const bool same =
        tip.found && best.found && (tip.p_I - best.p_I).cwiseAbs().maxCoeff() <= kSamePeak;
    if (same) continue;
    if (tip.found > best.found || (tip.found == best.found && tip.score > best.score)) {
      std::swap(tip, best);
    }
    if (tip.found && (!second.found || tip.score > second.score)) second = tip;
  }
  const bool unique = !second.found || second.score < best.score - kAsGood;
  best.found = best.found && unique && IsSureAgain(best);
  best.reacquired = best.found;
  return best;
}

bool TipTracker::IsSureAgain(const TipObservation& tip) const {
  const double noise = NoiseOf(whole_), signal = VarianceOf(ncc_.pattern());
  const double attenuation = std::sqrt(signal / (signal + noise * noise));
  return tip.aligned && tip.covered < kCoveredAgain &&
         tip.score >= (options_.min_score + kReacquired) * attenuation;
}

void TipTracker::FindCandidates(const cv::Mat& image) {
  format_.Read(image, cv::Rect(cv::Point(), format_.size()), whole_);
  if (shrink_ > 1) Shrink(whole_, shrink_, shrunk_);
  const ScoreMap& map = coarse_->Match(shrink_ > 1 ? shrunk_ : whole_);
  candidates_.clear();
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      const double score = map(y, x);
      const bool full = candidates_.size() == kCandidates;
      if (full && score <= candidates_.back().score) continue;
      if (!IsLocalPeak(map, x, y)) continue;
      if (full) candidates_.pop_back();
      const auto place = std::find_if(candidates_.begin(), candidates_.end(),
                                      [&](const Candidate& c) { return c.score < score; });
      candidates_.insert(place, {{x * shrink_, y * shrink_}, score});
    }
  }
}

}  // namespace palpate
