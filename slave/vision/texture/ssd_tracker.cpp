#include "slave/vision/texture/ssd_tracker.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Freedom = WindowTemplate::Freedom;

constexpr int kSmallestEdge = 9;      // of a window [px] [tuned: WhatCannotBeIsRefusedAtOnce]
constexpr double kCoarseMatch = 0.6;  // correlation below which a coarse place is not believed
constexpr int kNearby = 12;           // searched where the way down misled [px]
constexpr int kPicturesPerCut = 10;   // between two recent templates
constexpr int kSearchesPerPicture = 4;

void Check(const SsdOptions& options) {
  const int window = options.window;
  Require(window >= kSmallestEdge && window <= 255 && window % 2 == 1, "window", window,
          "an odd number from 9 to 255", " px");
  Require(options.levels >= 1 && options.levels <= 6, "levels", options.levels, "1 to 6");
  for (const double least : {options.least_correlation, options.refind_correlation}) {
    Require(least > 0 && least < 1, "correlation", least, "0 < c < 1");
  }
  Require(options.most_return_miss > 0, "most_return_miss", options.most_return_miss, "> 0", " px");
  Require(options.search_radius >= 0, "search_radius", options.search_radius, ">= 0", " px");
}

// The fine window's part of the picture, but never less than the smallest edge.
std::vector<WindowTemplate> TemplatesFor(int window, int levels) {
  std::vector<WindowTemplate> templates;
  for (int l = 0; l < levels; ++l) {
    templates.emplace_back(std::max(kSmallestEdge, (window >> l) | 1));
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
    Memory memory{empty, empty, {0, 0}, 0, 0};
    TrackedWindow window;
    window.warp.p = p;
    window.state = Cut(memory.first, window.warp) ? WindowState::kTracked : WindowState::kNoTexture;
    window.correlation = window.seen() ? 1 : -1;
    windows_.push_back(window);
    memories_.push_back(std::move(memory));
  }
}

SsdTracker SsdTracker::InOtherCamera(const cv::Mat& picture) const {
  SsdTracker other = *this;
  other.options_.search_radius = 0;
  const int levels = static_cast<int>(back_.size());  // those that have templates
  other.now_ = PicturePyramid(picture, levels);
  other.before_ = PicturePyramid(picture, levels);
  if (other.now_.levels() < levels) {
    throw std::invalid_argument("the other camera's image is too small for the pyramid");
  }
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    if (windows_[i].state != WindowState::kNoTexture) other.Lose(i);
    for (WindowTemplate& recent : other.memories_[i].recent) recent = WindowTemplate(recent.edge());
  }
  return other;
}

// The fine template decides; a coarse one without texture is left out of the way down.
bool SsdTracker::Cut(Templates& templates, const WindowWarp& warp) noexcept {
  for (std::size_t l = templates.size(); l-- > 1;) {
    const int level = static_cast<int>(l);
    templates[l].Cut(now_[level], warp.OnLevel(level), Freedom::kShift);
  }
  return templates.front().Cut(now_[0], warp);
}

WindowWarp SsdTracker::Coarse(Templates& templates, const PicturePyramid& picture,
                              const WindowWarp& start, int top) noexcept {
  WindowWarp warp = start;
  for (int level = top; level >= 0; --level) {
    const auto match = templates[static_cast<std::size_t>(level)].Align(
        picture[level], warp.OnLevel(level), Freedom::kShift);
    if (match.converged && match.correlation >= kCoarseMatch) warp = match.warp.FromLevel(level);
  }
  return warp;
}

WindowTemplate::Match SsdTracker::Descend(Templates& templates, const PicturePyramid& picture,
                                          const WindowWarp& start, int top) noexcept {
  return templates.front().Align(picture[0], Coarse(templates, picture, start, top),
                                 Freedom::kAffine);
}

WindowWarp SsdTracker::Search(Templates& templates, const PicturePyramid& picture,
                              const WindowWarp& start, int level, int radius) noexcept {
  WindowTemplate& window = templates[static_cast<std::size_t>(level)];
  const WindowWarp centre = start.OnLevel(level);
  WindowWarp best = centre;
  double best_score = -1;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const WindowWarp there{centre.A, centre.p + Eigen::Vector2d(dx, dy)};
      const double score = window.Score(picture[level], there);
      if (score > best_score) {
        best_score = score;
        best = there;
      }
    }
  }
  return best.FromLevel(level);
}

bool SsdTracker::Found(const WindowTemplate::Match& match, double least) noexcept {
  return match.converged && match.correlation >= least;
}

void SsdTracker::Accept(TrackedWindow& window, const WindowTemplate::Match& match,
                        WindowState state) noexcept {
  window.state = state;
  window.warp = match.warp;
  window.correlation = match.correlation;
  window.covariance = match.covariance;
}

// The window as it looks now, looked for in the picture before, starting where it is now.
bool SsdTracker::LeadsBack(const WindowWarp& now, const WindowWarp& before) noexcept {
  if (!Cut(back_, now)) return false;
  const int top = now_.levels() - 1, near = std::min(1, top);
  for (const bool search : {false, true}) {
    const WindowWarp start = search ? Search(back_, before_, now, near, kNearby >> near) : now;
    const WindowWarp coarse = Coarse(back_, before_, start, search ? 0 : top);
    const auto match = back_.front().Align(before_[0], coarse, Freedom::kShift);
    const bool back = (match.warp.p - before.p).norm() <= options_.most_return_miss;
    if (match.converged && back) return true;
  }
  return false;
}

// Down the pyramid from where it should be, and from where it was; where fine texture misled both,
// from the best of all places nearby.
bool SsdTracker::Follow(TrackedWindow& window, Memory& memory) noexcept {
  const WindowWarp before = window.warp;
  const WindowWarp predicted{before.A, before.p + memory.velocity};
  const int top = now_.levels() - 1, near = std::min(1, top);
  for (const bool bridge : {false, true}) {
    Templates& templates = bridge ? memory.recent : memory.first;
    if (!templates.front().textured()) continue;
    for (int attempt = 0; attempt < 4; ++attempt) {
      WindowWarp start = attempt % 2 == 0 ? predicted : before;
      const bool search = attempt >= 2;
      if (search) start = Search(templates, now_, start, near, kNearby >> near);
      const auto match = Descend(templates, now_, start, search ? 0 : top);
      if (!Found(match, options_.least_correlation) || !LeadsBack(match.warp, before)) continue;
      Accept(window, match, bridge ? WindowState::kBridged : WindowState::kTracked);
      memory.velocity = window.warp.p - before.p;
      if (!bridge && ++memory.since_cut >= kPicturesPerCut) {
        Cut(memory.recent, window.warp);
        memory.since_cut = 0;
      }
      return true;
    }
  }
  return false;
}

bool SsdTracker::Refind(TrackedWindow& window, Memory& memory) noexcept {
  const int top = now_.levels() - 1;
  const double wider = options_.window + 8.0 * memory.lost_for;
  const int radius = static_cast<int>(std::min<double>(options_.search_radius, wider)) >> top;
  const WindowWarp best = Search(memory.first, now_, window.warp, top, radius);
  const auto match = Descend(memory.first, now_, best, top);
  if (!Found(match, options_.refind_correlation)) return false;
  Accept(window, match, WindowState::kTracked);
  memory.velocity.setZero();
  return true;
}

const std::vector<TrackedWindow>& SsdTracker::Track(const cv::Mat& picture) noexcept {
  std::swap(now_, before_);
  if (!now_.Read(picture)) {
    std::swap(now_, before_);
    for (TrackedWindow& window : windows_) {
      if (window.state != WindowState::kNoTexture) window.state = WindowState::kBadPicture;
    }
    return windows_;
  }
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    TrackedWindow& window = windows_[i];
    // A picture that could not be read is jumped over: the picture before is the last good one.
    const bool follows =
        window.seen() || (window.state == WindowState::kBadPicture && memories_[i].lost_for == 0);
    if (window.state == WindowState::kNoTexture || !follows) continue;
    if (!Follow(window, memories_[i])) Lose(i);
  }
  int searches = kSearchesPerPicture;
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

bool SsdTracker::Place(std::size_t i, const WindowWarp& start) noexcept {
  TrackedWindow& window = windows_[i];
  if (window.state == WindowState::kNoTexture) return false;
  Memory& memory = memories_[i];
  const auto match = Descend(memory.first, now_, start, std::min(1, now_.levels() - 1));
  if (!Found(match, options_.least_correlation)) return false;
  Accept(window, match, WindowState::kTracked);
  memory.velocity.setZero();
  memory.lost_for = 0;
  return true;
}

void SsdTracker::Lose(std::size_t i) noexcept {
  windows_[i].state = WindowState::kLost;
  windows_[i].correlation = -1;
  memories_[i].velocity.setZero();
  memories_[i].lost_for = std::max(1, memories_[i].lost_for);
}

}  // namespace palpate
