#include "slave/vision/tip_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

constexpr int kSearchReach = 10;  // smallest search radius around the template [px]
constexpr int kSamePeak = 2;  // positions closer than this to the best belong to the same peak [px]
constexpr double kAsGood = 0.01;        // a second peak within this score of the best is its equal
constexpr std::size_t kCandidates = 6;  // candidates of the coarse search that are refined
constexpr double kCovered = 0.03;       // fraction of the template: a smaller covered part is noise
// Displacement of the fine alignment above which a small cover over the tip is excluded [px],
// [sigma].
constexpr double kPulled = 0.1, kPulledSigmas = 2;
// Limits of a peak of the scores in whole pixels: sigma at worst, and farthest place that belongs
// to it.
constexpr double kSigmaOfPeak = 0.5, kReachOfPeak = 2;  // [px]
// Covered share of the template from which its parts are evaluated.
constexpr double kMuchCovered = 0.4;
constexpr double kMaxCovered = 0.65;
// Scores of the parts relative to the usual score: smallest one that confirms a position, smallest
// one that does not contradict it, smallest one for a position from parts only; and of the second
// best position relative to the best.
constexpr double kAsUsual = 0.9, kMinAsUsual = 0.75, kPartsFit = 0.6, kPartsSecond = 0.88;
// Score by which the position from parts must exceed that of the whole template.
constexpr double kBetter = 0.03;
constexpr double kFollow = 0.05;      // weight of an image in the usual score
constexpr double kMinScore = 0.6;     // a lower score means that the tip is lost
constexpr double kReacquired = 0.15;  // margin over kMinScore if the tip may be anywhere
// Limits for a tip anywhere and a template without parts, which matches a tool's sides better than
// its end, so that another pipette fits along half of its length: margin of the noise-free score
// over kMinScore, and largest covered share.
constexpr double kFoundBlind = 0.3, kCoveredBlind = 0.15;
// Rotation of the tool [rad]: step of the search, largest change per image, smallest rotation that
// is used, largest rotation, and step while the tip is lost. Chosen with 12 presses by hand with up
// to 15 degrees; 24 others are within 1.5 % rms. Then: margin around the template [px], rounds per
// image.
constexpr double kTurnStep = 0.035, kMaxTurn = 0.05, kMinTurn = 0.01, kMaxSearchedTurn = 0.4;
constexpr std::array kTurnsTried{0.0, 0.1, -0.1, 0.2, -0.2};
constexpr int kTurnMargin = 6, kMaxTurns = 6;
constexpr int kMinCoarse = 7;  // edge below which a shrunk template has too little detail [px]

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

double SigmaOf(const PatchAligner::Match& match) {  // the worse axis [px]
  return std::sqrt(match.covariance.diagonal().maxCoeff());
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

// Returns the vector from the centroid of the template, weighted by gradients, to the anchor.
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

TipTracker::TipTracker(const TipTemplate& tip, const GreyFormat& format, int roi,
                       std::optional<Eigen::Vector2d> start_I)
    : format_(format),
      roi_(roi),
      anchor_(tip.anchor),
      centre_(tip.Centre()),
      lever_(LeverOf(tip)),
      ncc_(MakeNcc(tip, format)),
      aligner_(tip.Aligner()),
      parts_(tip),
      last_(start_I) {
  const int edge = std::min(tip.pixels.width, tip.pixels.height);
  for (shrink_ = 4; shrink_ > 1 && edge / shrink_ < kMinCoarse; shrink_ /= 2) {
  }
  for (; !coarse_; shrink_ /= 2) {
    GreyPatch pattern;
    Shrink(tip.pixels, shrink_, pattern);
    try {
      coarse_.emplace(pattern);
    } catch (const std::invalid_argument&) {
      if (shrink_ == 1) throw;
      continue;  // no contrast at this reduced size
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
    const int least = pattern_edge + 2 * kSearchReach;
    return static_cast<int>(scale * std::max(roi_, least));
  };
  const cv::Size size(edge(pattern.width), edge(pattern.height));
  const Eigen::Vector2d centre =
      tip - anchor_ + 0.5 * Eigen::Vector2d(pattern.width - 1, pattern.height - 1);
  const cv::Point corner(static_cast<int>(std::lround(centre.x())) - size.width / 2,
                         static_cast<int>(std::lround(centre.y())) - size.height / 2);
  return cv::Rect(corner, size) & cv::Rect(cv::Point(), format_.size());
}

cv::Rect TipTracker::search_window() const {
  return last_ ? WindowAround(Predicted(), 1) : cv::Rect(cv::Point(), format_.size());
}

// Rotates the image about the last tip [px] so that the tool has the direction of its template.
void TipTracker::Straighten(const cv::Mat& image) {
  const Eigen::Vector2d pivot = *last_;
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(turn_).toRotationMatrix();
  const Eigen::Vector2d shift = pivot - R * pivot;
  const cv::Matx23d back(R(0, 0), R(0, 1), shift.x(), R(1, 0), R(1, 1), shift.y());
  cv::warpAffine(image, straight_, back, image.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
}

// After a loss the tool may have rotated by more than the limit per image.
TipObservation TipTracker::Track(const cv::Mat& image) {
  const bool is_new = !last_;
  TipObservation tip = TrackTurned(image);
  const bool reacquired = tip.reacquired;
  for (int k = 0; k < kMaxTurns && is_new && tip.found && turn_ != 0; ++k) {
    const double before = turn_;
    tip = TrackTurned(image);
    tip.reacquired = reacquired;
    if (std::abs(turn_ - before) < kMinTurn) break;
  }
  return tip;
}

TipObservation TipTracker::TrackTurned(const cv::Mat& image) {
  if (!last_ && has_turned_ && lost_++ > 0) {
    turn_ = kTurnsTried[static_cast<std::size_t>(lost_) % kTurnsTried.size()];
  }
  if (turn_ == 0) {
    TipObservation tip = TrackStraight(image);
    FollowTurn(image, &tip);
    return tip;
  }
  if (!last_) last_ = Eigen::Vector2d(image.cols, image.rows) / 2;
  const bool was_lost = lost_ > 0;
  const Eigen::Vector2d pivot = *last_;
  const Eigen::Rotation2Dd R(turn_);
  Straighten(image);
  if (was_lost) last_.reset();
  step_ = R.inverse() * step_;
  TipObservation tip = TrackStraight(straight_);
  FollowTurn(straight_, &tip);
  if (!tip.found) return tip;
  tip.p_I = pivot + R * (tip.p_I - pivot);
  tip.lever = R * tip.lever;
  last_ = tip.p_I;
  step_ = R * step_;
  return tip;
}

// Finds the angle of the best correlation with a parabola. A cover must not change the angle.
void TipTracker::FollowTurn(const cv::Mat& image, TipObservation* tip) {
  if (!tip->found) return;
  lost_ = 0;
  tip->turn = turn_;
  if (!tip->aligned || tip->covered > kMuchCovered) return;
  const GreyPatch& pattern = ncc_.pattern();
  const Eigen::Vector2d corner = tip->p_I - anchor_;
  const cv::Rect wanted(static_cast<int>(corner.x()) - kTurnMargin,
                        static_cast<int>(corner.y()) - kTurnMargin, pattern.width + 2 * kTurnMargin,
                        pattern.height + 2 * kTurnMargin);
  const cv::Rect window = wanted & cv::Rect(cv::Point(), format_.size());
  if (window != wanted) return;
  format_.Read(image, window, near_);
  const Eigen::Vector2d p = tip->p_I - Eigen::Vector2d(window.x, window.y);
  const auto turned = [&](double angle) -> PatchWarp {
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(angle).toRotationMatrix();
    return {R, p + R * (centre_ - anchor_)};
  };
  std::array<double, 3> fit{};
  for (std::size_t k = 0; k < fit.size(); ++k) {
    const double angle = kTurnStep * (static_cast<double>(k) - 1);
    fit[k] = aligner_.Align(near_.Mat(), turned(angle), PatchAligner::Freedom::kShift).correlation;
  }
  const double bend = fit[0] - 2 * fit[1] + fit[2];
  if (!(bend < 0)) return;
  const double turn = std::clamp(kTurnStep * (fit[0] - fit[2]) / (2 * bend), -kMaxTurn, kMaxTurn);
  if (!has_turned_ && std::abs(turn) < kMinTurn) return;
  const PatchAligner::Match fine = aligner_.AlignRobustly(near_.Mat(), turned(turn), {});
  if (!fine.converged) return;
  has_turned_ = true;
  turn_ = std::clamp(turn_ + turn, -kMaxSearchedTurn, kMaxSearchedTurn);
  tip->turn = turn_;
  tip->p_I = fine.warp.p + fine.warp.A * (anchor_ - centre_) + Eigen::Vector2d(window.x, window.y);
  tip->sigma = SigmaOf(fine);
  last_ = tip->p_I;
}

TipObservation TipTracker::TrackStraight(const cv::Mat& image) {
  Match match;
  if (last_) {
    match = SearchWindow(image, WindowAround(Predicted(), 1));
    if (match.on_border) {
      // A partly covered bar also matches at other positions along itself; its marks do not.
      const Match around = SearchWindow(image, WindowAround(Predicted(), 2));
      if (!(match.tip.found && match.fit > around.fit + kBetter)) match = around;
    }
  }
  if (!match.tip.found) match.tip = SearchImage(image);
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
  match.on_border = best.score >= kMinScore && OnBorder(map, best.at);
  if (match.on_border) {
    const double usual = parts_.usable() ? usual_ * parts_.Attenuation(NoiseOf(window_)) : 0;
    const TipObservation by_parts = MeasureByParts(window, usual);
    if (by_parts.found && by_parts.score >= kMinAsUsual * usual) {
      match.tip = by_parts;
      match.fit = by_parts.score;
    }
    return match;
  }
  if (best.score >= kMinScore && !HasEqual(map, best)) {
    match.tip = Measure(best.score, window, best.at);
  }
  match.fit = Confirm(window, best.at, match.tip);
  return match;
}

// Confirms `tip`, which the whole template found at `peak`, by the parts that vary along the tool.
// If they disagree, the parts determine the tip.
double TipTracker::Confirm(const cv::Rect& window, const cv::Point& peak, TipObservation& tip) {
  if (!parts_.usable()) {
    tip.found &= tip.covered < kMaxCovered;
    return 0;
  }
  const double score = tip.found ? parts_.ScoreNear(window_, peak) : 0;
  const double attenuation = parts_.Attenuation(NoiseOf(window_));
  // The image from which the template was cut fits it better than any other image.
  if (tip.found && usual_ == 0) usual_ = std::min(1.0, score / attenuation);
  const double usual = usual_ * attenuation;
  const bool fits = tip.found && score >= kMinAsUsual * usual;
  const bool as_usual = tip.found && score >= kAsUsual * usual && tip.covered < kMuchCovered;
  // Blur reduces every score, but a covered tip must not change the usual score.
  if (fits && tip.covered < kCovered) {
    usual_ += kFollow * (std::min(1.0, score / attenuation) - usual_);
  }
  if (as_usual) return score;
  const TipObservation by_parts = MeasureByParts(window, usual);
  const bool better = by_parts.found && by_parts.score > score + kBetter;
  if (better) {
    const double whole = tip.score;
    tip = by_parts;
    tip.score = std::max(by_parts.score, whole);
  } else {
    tip.found = fits;
  }
  tip.found &= tip.covered < kMaxCovered;
  return better ? by_parts.score : score;
}

TipObservation TipTracker::MeasureByParts(const cv::Rect& window, double usual) {
  TipObservation tip;
  if (usual == 0) return tip;
  const TemplateParts::Place place = parts_.Find(window_);
  if (place.on_border || place.score < kPartsFit * usual ||
      place.second > kPartsSecond * place.score)
    return tip;
  const PatchAligner::Match fine =
      aligner_.AlignRobustly(window_.Mat(), PatchAt(place.at), parts_.trust());
  if (!fine.converged) return tip;
  SetPosition(fine, window, &tip);
  tip.found = true;
  tip.score = place.score;
  return tip;
}

TipObservation TipTracker::Measure(double score, const cv::Rect& window, const cv::Point& peak) {
  const PatchWarp start = PatchAt(peak);
  PatchAligner::Match fine = aligner_.Align(window_.Mat(), start, PatchAligner::Freedom::kShift);
  fine.converged &= (fine.warp.p - start.p).cwiseAbs().maxCoeff() <= kReachOfPeak;
  const PatchAligner::Match around =
      aligner_.AlignRobustly(window_.Mat(), fine.converged ? fine.warp : start, {});
  const double apart = (around.warp.p - fine.warp.p).cwiseAbs().maxCoeff();
  const bool pulled = apart > kPulled + kPulledSigmas * SigmaOf(around);
  if (around.converged && (!fine.converged || around.covered > kCovered || pulled)) fine = around;
  if (!fine.converged) fine.warp = start;
  TipObservation tip;
  SetPosition(fine, window, &tip);
  tip.found = true;
  tip.score = score;
  return tip;
}

PatchWarp TipTracker::PatchAt(const cv::Point& corner) const {
  return {.p = centre_ + Eigen::Vector2d(corner.x, corner.y)};
}

void TipTracker::SetPosition(const PatchAligner::Match& fine, const cv::Rect& window,
                             TipObservation* tip) const {
  tip->p_I = fine.warp.p - centre_ + anchor_ + Eigen::Vector2d(window.x, window.y);
  tip->covered = fine.covered;
  tip->aligned = fine.converged;
  tip->sigma = fine.converged ? SigmaOf(fine) : kSigmaOfPeak;
}

TipObservation TipTracker::SearchImage(const cv::Mat& image) {
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
  if (parts_.usable()) return tip.score >= kMinScore + kReacquired;
  const double noise = NoiseOf(whole_), signal = VarianceOf(ncc_.pattern());
  const double attenuation = std::sqrt(signal / (signal + noise * noise));
  return tip.aligned && tip.covered < kCoveredBlind &&
         tip.score >= (kMinScore + kFoundBlind) * attenuation;
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
