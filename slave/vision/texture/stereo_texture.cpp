#include "slave/vision/texture/stereo_texture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kLevel = FlowTracker::kCoarseLevel;  // on which one camera searches the other's image
constexpr int kSearchesPerPair =
    4;  // [-] [tuned: APointLostInOneCameraIsInvisibleUntilRaysMeetAgain]

bool IsImage(const cv::Mat& image, const Lens& lens) {
  return image.dims == 2 && image.data != nullptr &&
         (image.type() == CV_8UC1 || image.type() == CV_8UC3) && image.cols == lens.size[0] &&
         image.rows == lens.size[1];
}

void Check(const StereoTextureOptions& options) {
  Require(options.count >= 1 && options.count <= 10000, "count", 1.0 * options.count, "1 to 10000");
  Require(options.sigma > 0, "sigma", options.sigma, "> 0 [px]");
  Require(options.max_miss > 0, "max_miss", options.max_miss, "> 0 [px]");
}

}  // namespace

StereoTextureOptions StereoTextureOptions::From(const PointTracking& points) {
  StereoTextureOptions options;
  options.at = points.at;
  options.count = points.count;
  options.sigma = points.sigma;
  options.flow.window = points.window;
  return options;
}

StereoTexture::StereoTexture(const StereoRig& rig, const Eigen::Isometry3d& X_SL,
                             const StereoTextureOptions& options)
    : rig_(rig), X_RL_(rig.X_RL), X_LR_(rig.X_RL.inverse()), X_SL_(X_SL), options_(options) {
  Check(options);
  FlowTracker(cv::Mat::zeros(64, 64, CV_8UC1), {}, options.flow);  // checks the options
}

StereoTexture::~StereoTexture() = default;

bool StereoTexture::Start(const cv::Mat& left, const cv::Mat& right) {
  const int edge = options_.flow.window;
  const auto at =
      !options_.at.empty() ? options_.at : ChooseWindows(left, options_.count, edge, 0.5 * edge);
  if (at.empty()) return false;
  auto first = std::make_unique<FlowTracker>(left, at, options_.flow);
  auto second = std::make_unique<FlowTracker>(first->InOtherCamera(right));
  back_ = std::make_unique<PatchAligner>(first->coarse_template(0).edge());
  has_rest_.assign(at.size(), false);
  observation_.points.assign(at.size(), {});
  left_ = std::move(first);  // no exceptions from here on, so that both are set or none
  right_ = std::move(second);
  bool any = false;
  for (std::size_t i = 0; i < at.size(); ++i) {
    observation_.points[i].id = static_cast<int>(i);
    RelocateLostSide(i);
    any = Locate(i) || any;
  }
  if (!any) {
    left_.reset();
    right_.reset();
    observation_.points.clear();
  }
  return any;
}

// Searches a window that one camera tracks in the image of the camera that has lost it or never had
// it.
void StereoTexture::RelocateLostSide(std::size_t i) noexcept {
  const TrackedWindow &l = left_->windows()[i], &r = right_->windows()[i];
  if (l.seen == r.seen) return;
  const bool to_left = r.seen;
  FlowTracker& other = to_left ? *left_ : *right_;
  const auto there =
      to_left ? SearchEpipolar(rig_.right, rig_.left, X_LR_, r.warp, left_->coarse_template(i),
                               left_->coarse_image(), kLevel, options_.search)
              : SearchEpipolar(rig_.left, rig_.right, X_RL_, l.warp, right_->coarse_template(i),
                               right_->coarse_image(), kLevel, options_.search);
  if (there && other.Place(i, *there) && !ReturnsToStart(i, to_left)) other.Lose(i);
}

// Returns whether the window in the found image is found again at its position in the other image.
bool StereoTexture::ReturnsToStart(std::size_t i, bool to_left) noexcept {
  const PatchWarp &l = left_->windows()[i].warp, &r = right_->windows()[i].warp;
  const PatchWarp &found = to_left ? l : r, &known = to_left ? r : l;
  const cv::Mat& image = (to_left ? left_ : right_)->coarse_image();
  if (!back_->Cut(image, found.OnLevel(kLevel), PatchAligner::Freedom::kShift)) return false;
  EpipolarOptions best_alone = options_.search;
  best_alone.min_margin = 0;
  const auto home = to_left ? SearchEpipolar(rig_.left, rig_.right, X_RL_, found, *back_,
                                             right_->coarse_image(), kLevel, best_alone)
                            : SearchEpipolar(rig_.right, rig_.left, X_LR_, found, *back_,
                                             left_->coarse_image(), kLevel, best_alone);
  const double max_miss = 2 * (1 << kLevel);  // [px]; step of the search
  return home && (home->p - known.p).norm() <= max_miss;
}

bool StereoTexture::Locate(std::size_t i) noexcept {
  SurfacePoint& point = observation_.points[i];
  point.seen = false;
  const TrackedWindow &l = left_->windows()[i], &r = right_->windows()[i];
  if (!l.seen || !r.seen) return false;
  // Uses the worse axis of both images, but at least the scene's value.
  const double variance = std::max(l.covariance.trace(), r.covariance.trace()) / 2;
  const double sigma = std::max(options_.sigma, std::sqrt(variance));
  const auto met = Triangulate(rig_, l.warp.p, r.warp.p, sigma);
  if (!met || std::abs(met->miss_px) > options_.max_miss) {
    right_->Lose(i);  // the templates are from the left camera, so its window is more reliable
    return false;
  }
  point.seen = true;
  point.left_I = l.warp.p;
  point.right_I = r.warp.p;
  point.sigma_px = std::sqrt(variance);
  point.miss_px = met->miss_px;
  point.p_S = X_SL_ * met->p_L;
  point.covariance = X_SL_.linear() * met->covariance * X_SL_.linear().transpose();
  if (!has_rest_[i]) {
    point.p_S_rest = point.p_S;
    has_rest_[i] = true;
  }
  return true;
}

void StereoTexture::Pair() noexcept {
  const std::size_t count = observation_.points.size();
  int searches = kSearchesPerPair;
  for (std::size_t n = 0; n < count && searches > 0; ++n) {
    const std::size_t i = (next_search_ + n) % count;
    if (left_->windows()[i].seen == right_->windows()[i].seen) continue;
    RelocateLostSide(i);
    if (--searches == 0) next_search_ = i + 1;
  }
  for (std::size_t i = 0; i < count; ++i) observation_.found |= Locate(i);
}

const SurfaceObservation& StereoTexture::Process(const cv::Mat& left, const cv::Mat& right) {
  observation_.found = false;
  for (SurfacePoint& point : observation_.points) point.seen = false;
  const bool usable = IsImage(left, rig_.left) && IsImage(right, rig_.right);
  if (!started()) {
    observation_.found = usable && Start(left, right);
    return observation_;
  }
  if (!usable) return observation_;
  left_->Track(left);
  right_->Track(right);
  Pair();
  return observation_;
}

const std::vector<TrackedWindow>& StereoTexture::left_windows() const {
  static const std::vector<TrackedWindow> none;
  return left_ ? left_->windows() : none;
}

}  // namespace palpate
