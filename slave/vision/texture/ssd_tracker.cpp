#include "slave/vision/texture/ssd_tracker.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Freedom = PatchAligner::Freedom;

constexpr int kMinEdge = 9;           // of a window [px] [tuned: WhatCannotBeIsRefusedAtOnce]
constexpr double kCoarseMatch = 0.6;  // correlation below which a coarse position is rejected
constexpr int kNearby = 12;           // search radius if the coarse levels were misleading [px]
constexpr int kSearchesPerImage = 4;

void Check(const SsdOptions& options) {
  const int window = options.window;
  Require(window >= kMinEdge && window <= 255 && window % 2 == 1, "window", window,
          "an odd number from 9 to 255", " px");
  Require(options.levels >= 1 && options.levels <= 6, "levels", options.levels, "1 to 6");
  for (const double least : {options.min_correlation, options.refind_correlation}) {
    Require(least > 0 && least < 1, "correlation", least, "0 < c < 1");
  }
  Require(options.max_return_miss > 0, "max_return_miss", options.max_return_miss, "> 0", " px");
  Require(options.search_radius >= 0, "search_radius", options.search_radius, ">= 0", " px");
}

// Makes templates for coarse levels that cover the same part of the image as the fine window, but
// at least the smallest edge.
std::vector<PatchAligner> TemplatesFor(int window, int levels) {
  std::vector<PatchAligner> templates;
  for (int l = 0; l < levels; ++l) {
    templates.emplace_back(std::max(kMinEdge, (window >> l) | 1));
  }
  return templates;
}

}  // namespace

SsdTracker::SsdTracker(const cv::Mat& first, const std::vector<Eigen::Vector2d>& at,
                       const SsdOptions& options)
    : options_((Check(options), options)),
      now_(first, options.levels),
      before_(first, options.levels),
      back_(TemplatesFor(options.window, now_.levels())) {
  const Templates empty = TemplatesFor(options.window, now_.levels());
  for (const Eigen::Vector2d& p : at) {
    Memory memory{empty, {0, 0}, 0};
    TrackedWindow window;
    window.warp.p = p;
    window.state = Cut(memory.first, window.warp) ? WindowState::kTracked : WindowState::kNoTexture;
    windows_.push_back(window);
    memories_.push_back(std::move(memory));
  }
}

SsdTracker SsdTracker::InOtherCamera(const cv::Mat& image) const {
  SsdTracker other = *this;
  other.options_.search_radius = 0;
  const int levels = static_cast<int>(back_.size());  // number of levels with templates
  other.now_ = ImagePyramid(image, levels);
  other.before_ = ImagePyramid(image, levels);
  if (other.now_.levels() < levels) {
    throw std::invalid_argument("the other camera's image is too small for the pyramid");
  }
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    if (windows_[i].state != WindowState::kNoTexture) other.Lose(i);
  }
  return other;
}

// The fine template is required; coarse levels without texture are skipped.
bool SsdTracker::Cut(Templates& templates, const PatchWarp& warp) noexcept {
  for (std::size_t l = templates.size(); l-- > 1;) {
    const int level = static_cast<int>(l);
    templates[l].Cut(now_[level], warp.OnLevel(level), Freedom::kShift);
  }
  return templates.front().Cut(now_[0], warp);
}

PatchWarp SsdTracker::Coarse(Templates& templates, const ImagePyramid& image,
                             const PatchWarp& start, int top) noexcept {
  PatchWarp warp = start;
  for (int level = top; level >= 0; --level) {
    const auto match = templates[static_cast<std::size_t>(level)].Align(
        image[level], warp.OnLevel(level), Freedom::kShift);
    if (match.converged && match.correlation >= kCoarseMatch) warp = match.warp.FromLevel(level);
  }
  return warp;
}

PatchAligner::Match SsdTracker::Descend(Templates& templates, const ImagePyramid& image,
                                        const PatchWarp& start, int top) noexcept {
  return templates.front().Align(image[0], Coarse(templates, image, start, top), Freedom::kAffine);
}

PatchWarp SsdTracker::Search(Templates& templates, const ImagePyramid& image,
                             const PatchWarp& start, int level, int radius) noexcept {
  PatchAligner& window = templates[static_cast<std::size_t>(level)];
  const PatchWarp centre = start.OnLevel(level);
  PatchWarp best = centre;
  double best_score = -1;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const PatchWarp there{centre.A, centre.p + Eigen::Vector2d(dx, dy)};
      const double score = window.Score(image[level], there);
      if (score > best_score) {
        best_score = score;
        best = there;
      }
    }
  }
  return best.FromLevel(level);
}

bool SsdTracker::Found(const PatchAligner::Match& match, double least) noexcept {
  return match.converged && match.correlation >= least;
}

void SsdTracker::Accept(TrackedWindow& window, const PatchAligner::Match& match) noexcept {
  window.state = WindowState::kTracked;
  window.warp = match.warp;
  window.covariance = match.covariance;
}

// Searches the present window in the previous image, from its present position.
bool SsdTracker::ReturnsToStart(const PatchWarp& now, const PatchWarp& before) noexcept {
  if (!Cut(back_, now)) return false;
  const int top = now_.levels() - 1, near = std::min(1, top);
  for (const bool search : {false, true}) {
    const PatchWarp start = search ? Search(back_, before_, now, near, kNearby >> near) : now;
    const PatchWarp coarse = Coarse(back_, before_, start, search ? 0 : top);
    const auto match = back_.front().Align(before_[0], coarse, Freedom::kShift);
    const bool back = (match.warp.p - before.p).norm() <= options_.max_return_miss;
    if (match.converged && back) return true;
  }
  return false;
}

// Tracks down the pyramid from the predicted position and from the last one; if both fail, from the
// best of all positions nearby.
bool SsdTracker::Follow(TrackedWindow& window, Memory& memory) noexcept {
  const PatchWarp before = window.warp;
  const PatchWarp predicted{before.A, before.p + memory.velocity};
  const int top = now_.levels() - 1, near = std::min(1, top);
  for (const bool search : {false, true}) {
    for (PatchWarp start : {predicted, before}) {
      if (search) start = Search(memory.first, now_, start, near, kNearby >> near);
      const auto match = Descend(memory.first, now_, start, search ? 0 : top);
      if (!Found(match, options_.min_correlation) || !ReturnsToStart(match.warp, before)) continue;
      Accept(window, match);
      memory.velocity = window.warp.p - before.p;
      return true;
    }
  }
  return false;
}

bool SsdTracker::Refind(TrackedWindow& window, Memory& memory) noexcept {
  const int top = now_.levels() - 1;
  const double wider = options_.window + 8.0 * memory.lost_for;
  const int radius = static_cast<int>(std::min<double>(options_.search_radius, wider)) >> top;
  const PatchWarp best = Search(memory.first, now_, window.warp, top, radius);
  const auto match = Descend(memory.first, now_, best, top);
  if (!Found(match, options_.refind_correlation)) return false;
  Accept(window, match);
  memory.velocity.setZero();
  return true;
}

const std::vector<TrackedWindow>& SsdTracker::Track(const cv::Mat& image) noexcept {
  std::swap(now_, before_);
  if (!now_.Read(image)) {
    std::swap(now_, before_);
    for (TrackedWindow& window : windows_) {
      if (window.state != WindowState::kNoTexture) window.state = WindowState::kBadImage;
    }
    return windows_;
  }
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    TrackedWindow& window = windows_[i];
    // An unreadable image is skipped: the previous image is the last good one.
    const bool follows =
        window.seen() || (window.state == WindowState::kBadImage && memories_[i].lost_for == 0);
    if (window.state == WindowState::kNoTexture || !follows) continue;
    if (!Follow(window, memories_[i])) Lose(i);
  }
  int searches = kSearchesPerImage;
  const std::size_t first = next_search_;
  for (std::size_t n = 0; n < windows_.size(); ++n) {
    const std::size_t i = (first + n) % windows_.size();
    if (windows_[i].seen() || windows_[i].state == WindowState::kNoTexture) continue;
    windows_[i].state = WindowState::kLost;
    ++memories_[i].lost_for;
    if (searches == 0 || options_.search_radius == 0) continue;
    if (--searches == 0) next_search_ = i + 1;
    if (Refind(windows_[i], memories_[i])) memories_[i].lost_for = 0;
  }
  return windows_;
}

bool SsdTracker::Place(std::size_t i, const PatchWarp& start) noexcept {
  TrackedWindow& window = windows_[i];
  if (window.state == WindowState::kNoTexture) return false;
  Memory& memory = memories_[i];
  const auto match = Descend(memory.first, now_, start, std::min(1, now_.levels() - 1));
  if (!Found(match, options_.min_correlation)) return false;
  Accept(window, match);
  memory.velocity.setZero();
  memory.lost_for = 0;
  return true;
}

void SsdTracker::Lose(std::size_t i) noexcept {
  windows_[i].state = WindowState::kLost;
  memories_[i].velocity.setZero();
  memories_[i].lost_for = std::max(1, memories_[i].lost_for);
}

}  // namespace palpate
