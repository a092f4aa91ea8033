#include "slave/vision/texture/flow_tracker.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "shared/text/text.h"
#include "slave/statistics/robust.h"

namespace palpate {
namespace {

using Freedom = PatchAligner::Freedom;

constexpr int kMinEdge = 9;           // of a window [px] [tuned: WhatCannotBeIsRefusedAtOnce]
constexpr int kMinSize = 32;          // of an image [px] [tuned: WhatCannotBeIsRefusedAtOnce]
constexpr double kCoarseMatch = 0.6;  // correlation below which a coarse position is rejected
constexpr int kLevels = 3;            // of the flow's pyramid above the image itself
const cv::Size kFlowWindow(21, 21);   // [px]
// The alignment that follows needs a part of a pixel only.
const cv::TermCriteria kSettled(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.03);

void Check(const FlowOptions& options) {
  const int window = options.window;
  Require(window >= kMinEdge && window <= 255 && window % 2 == 1, "window", window,
          "an odd number from 9 to 255", " px");
  for (const double least : {options.min_correlation, options.refind_correlation}) {
    Require(least > 0 && least < 1, "correlation", least, "0 < c < 1");
  }
  Require(options.max_return_miss > 0, "max_return_miss", options.max_return_miss, "> 0", " px");
}

cv::Point2f PointOf(const Eigen::Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}

Eigen::Vector2d VectorOf(const cv::Point2f& p) {
  return {p.x, p.y};
}

bool IsReadable(const cv::Mat& image) {
  return image.dims == 2 && (image.type() == CV_8UC1 || image.type() == CV_8UC3);
}

}  // namespace

FlowTracker::Image FlowTracker::Read(const cv::Mat& image) {
  if (!IsReadable(image)) {
    throw std::invalid_argument("image of texture: expected 8 bit grey or BGR");
  }
  if (image.cols < kMinSize || image.rows < kMinSize) {
    throw std::invalid_argument(fmt::format("image of texture: {} x {} px: expected {} px and more",
                                            image.cols, image.rows, kMinSize));
  }
  Image out;
  if (image.channels() == 3) {
    cv::cvtColor(image, out.grey, cv::COLOR_BGR2GRAY);
  } else {
    out.grey = image.clone();
  }
  const cv::Size half(image.cols / 2, image.rows / 2);
  cv::resize(out.grey(cv::Rect({0, 0}, half * 2)), out.coarse, half, 0, 0, cv::INTER_AREA);
  cv::buildOpticalFlowPyramid(out.grey, out.pyramid, kFlowWindow, kLevels);
  return out;
}

FlowTracker::FlowTracker(const cv::Mat& first, const std::vector<Eigen::Vector2d>& at,
                         const FlowOptions& options)
    : options_((Check(options), options)), first_(Read(first)), now_(first_) {
  const int coarse_edge = std::max(kMinEdge, (options.window >> kCoarseLevel) | 1);
  for (const Eigen::Vector2d& p : at) {
    Templates templates{p, PatchAligner(options.window), PatchAligner(coarse_edge)};
    TrackedWindow window;
    window.warp.p = p;
    templates.coarse.Cut(now_.coarse, window.warp.OnLevel(kCoarseLevel), Freedom::kShift);
    window.has_texture = window.seen = templates.fine.Cut(now_.grey, window.warp);
    windows_.push_back(window);
    templates_.push_back(std::move(templates));
  }
}

FlowTracker FlowTracker::InOtherCamera(const cv::Mat& image) const {
  FlowTracker other = *this;
  other.now_ = Read(image);
  other.finds_lost_ = false;
  for (TrackedWindow& window : other.windows_) window.seen = false;
  return other;
}

// Moves the points of `flow` from `before` to the present image, and back as a check.
void FlowTracker::Follow(const Image& before, Flow* flow) const {
  flow->returns.clear();
  if (flow->from.empty()) return;
  std::vector<cv::Point2f> home = flow->from, guess = flow->to;
  std::vector<std::uint8_t> found, found_back;
  cv::calcOpticalFlowPyrLK(before.pyramid, now_.pyramid, flow->from, flow->to, found, cv::noArray(),
                           kFlowWindow, kLevels, kSettled, cv::OPTFLOW_USE_INITIAL_FLOW);
  for (std::size_t k = 0; k < home.size(); ++k) home[k] += flow->to[k] - guess[k];
  cv::calcOpticalFlowPyrLK(now_.pyramid, before.pyramid, flow->to, home, found_back, cv::noArray(),
                           kFlowWindow, kLevels, kSettled, cv::OPTFLOW_USE_INITIAL_FLOW);
  for (std::size_t k = 0; k < home.size(); ++k) {
    flow->returns.push_back(found[k] != 0 && found_back[k] != 0 &&
                            cv::norm(home[k] - flow->from[k]) <= options_.max_return_miss);
  }
}

// Aligns the window of the first image. Accepts it from `min_correlation` on.
bool FlowTracker::Align(std::size_t i, const PatchWarp& start, double min_correlation) noexcept {
  const auto match = templates_[i].fine.Align(now_.grey, start, Freedom::kAffine);
  TrackedWindow& window = windows_[i];
  window.seen = match.converged && match.correlation >= min_correlation;
  if (!window.seen) return false;
  window.warp = match.warp;
  window.covariance = match.covariance;
  return true;
}

// Returns the median motion [px].
Eigen::Vector2d FlowTracker::FollowSeen(const Image& before) {
  Flow flow;
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    if (!windows_[i].seen) continue;
    flow.windows.push_back(i);
    flow.from.push_back(PointOf(windows_[i].warp.p));
  }
  flow.to = flow.from;
  Follow(before, &flow);
  std::vector<double> x, y;
  for (std::size_t k = 0; k < flow.windows.size(); ++k) {
    TrackedWindow& window = windows_[flow.windows[k]];
    window.seen = false;
    const PatchWarp last = window.warp;
    if (!flow.returns[k] ||
        !Align(flow.windows[k], {last.A, VectorOf(flow.to[k])}, options_.min_correlation)) {
      continue;
    }
    x.push_back(window.warp.p.x() - last.p.x());
    y.push_back(window.warp.p.y() - last.p.y());
  }
  if (x.empty()) return {0, 0};
  return {MedianOf(std::move(x)), MedianOf(std::move(y))};
}

void FlowTracker::FindLost(const Eigen::Vector2d& motion) {
  Flow flow;
  for (std::size_t i = 0; i < windows_.size(); ++i) {
    if (windows_[i].seen || !windows_[i].has_texture) continue;
    windows_[i].warp.p += motion;
    flow.windows.push_back(i);
    flow.from.push_back(PointOf(templates_[i].centre));
    flow.to.push_back(PointOf(windows_[i].warp.p));
  }
  Follow(first_, &flow);
  for (std::size_t k = 0; k < flow.windows.size(); ++k) {
    const std::size_t i = flow.windows[k];
    if (!flow.returns[k]) continue;
    Align(i, {windows_[i].warp.A, VectorOf(flow.to[k])}, options_.refind_correlation);
  }
}

const std::vector<TrackedWindow>& FlowTracker::Track(const cv::Mat& image) {
  const Image before = std::exchange(now_, Read(image));
  const Eigen::Vector2d motion = FollowSeen(before);
  if (finds_lost_) FindLost(motion);
  return windows_;
}

bool FlowTracker::Place(std::size_t i, const PatchWarp& start) noexcept {
  if (!windows_[i].has_texture) return false;
  const auto coarse =
      templates_[i].coarse.Align(now_.coarse, start.OnLevel(kCoarseLevel), Freedom::kShift);
  const bool is_near = coarse.converged && coarse.correlation >= kCoarseMatch;
  return Align(i, is_near ? coarse.warp.FromLevel(kCoarseLevel) : start, options_.min_correlation);
}

std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& image, int count, int edge,
                                           double apart) {
  const int rim = edge / 2 + 2;
  if (!IsReadable(image) || count < 1 || edge < 1 || image.cols <= 2 * rim ||
      image.rows <= 2 * rim) {
    return {};
  }
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat inside = cv::Mat::zeros(grey.size(), CV_8UC1);
  inside(cv::Rect(rim, rim, grey.cols - 2 * rim, grey.rows - 2 * rim)).setTo(255);
  constexpr double kOfTheBest = 0.01;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, count, kOfTheBest, apart, inside, edge);
  std::vector<Eigen::Vector2d> centres;
  centres.reserve(corners.size());
  for (const cv::Point2f& corner : corners) centres.push_back(VectorOf(corner));
  return centres;
}

}  // namespace palpate
