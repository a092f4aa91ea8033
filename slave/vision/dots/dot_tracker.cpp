#include "slave/vision/dots/dot_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include "shared/geometry/index.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

bool IsGrey(const cv::Mat& image) noexcept {
  return image.dims == 2 && image.type() == CV_8UC1 && image.data != nullptr && image.cols > 0 &&
         image.rows > 0;
}

bool TouchesEdge(const Blob& blob, const cv::Mat& image) noexcept {
  return blob.left == 0 || blob.top == 0 || blob.right == image.cols - 1 ||
         blob.bottom == image.rows - 1;
}

// The darkest and the lightest value.
std::array<int, 2> Extremes(const cv::Mat& image) noexcept {
  std::uint8_t darkest = 255, lightest = 0;
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.cols; ++x) {
      darkest = std::min(darkest, row[x]);
      lightest = std::max(lightest, row[x]);
    }
  }
  return {darkest, lightest};
}

constexpr int kRecheck = 8;  // pictures with a dot missing between two whole searches
// Less than so much of the last picture's dots. [-] [tuned:
// JumpOfOneColumnIsNotTakenForStandingStill]
constexpr double kManyLost = 0.85;
constexpr double kSearch = 0.4;    // how far a dot is looked for, in spacings
constexpr double kStray = 0.25;    // how far a dot may be from where its neighbours put it
constexpr double kStrayFloor = 3;  // but never less [px]

Eigen::Vector2d Extent(const Dot& dot) {
  return {2 * std::sqrt(dot.shape(0, 0)), 2 * std::sqrt(dot.shape(1, 1))};
}

}  // namespace

DotFinder::DotFinder(const Params& params) : params_(params) {
  const DotShapeLimits& limits = params.limits;
  Require(limits.area_min >= 5, "area_min", limits.area_min, "at least 5 px^2");
  Require(limits.area_max > limits.area_min, "area_max", limits.area_max, "more than area_min");
  Require(limits.axes_ratio_min > 0 && limits.axes_ratio_min <= 1, "axes_ratio_min",
          limits.axes_ratio_min, "0 < ratio <= 1");
  Require(limits.contrast_min >= 1 && limits.contrast_min <= 255, "contrast_min",
          limits.contrast_min, "1 to 255");
}

bool DotFinder::Find(const cv::Mat& image, std::vector<Dot>* dots) noexcept try {
  dots->clear();
  if (!IsGrey(image)) return false;
  dots->reserve(params_.most);
  if (!thresholds_.Fit(image, static_cast<int>(params_.limits.contrast_min))) return true;
  bits_.resize(Index(image.cols + 63) / 64);
  labeller_.Begin(image.cols);
  for (int y = 0; y < image.rows; ++y) {
    DarkBits(image.ptr<std::uint8_t>(y), image.cols, thresholds_.Row(y), bits_.data());
    labeller_.AddRow(y, bits_.data(), params_.tone == DotTone::kLight);
  }
  for (const Blob& blob : labeller_.Finish()) {
    if (dots->size() == params_.most) break;
    if (TouchesEdge(blob, image)) continue;
    const auto ellipse = EllipseOf(blob, params_.limits);
    if (!ellipse) continue;
    const int threshold = thresholds_.At(static_cast<int>(ellipse->centre.x()),
                                         static_cast<int>(ellipse->centre.y()));
    const auto dot = RefineDot(image, *ellipse, threshold, params_.tone, params_.limits);
    if (dot) dots->push_back(*dot);
  }
  return true;
} catch (const std::exception&) {
  dots->clear();
  return false;
}

bool DotFinder::Track(const cv::Mat& image, const std::vector<ExpectedDot>& expected,
                      std::vector<SightedDot>* sighted) noexcept try {
  sighted->assign(expected.size(), {});
  if (!IsGrey(image)) return false;
  bits_.resize(Index(image.cols + 63) / 64);
  one_threshold_.resize(Index(image.cols + 15) / 16);
  for (std::size_t k = 0; k < expected.size(); ++k) (*sighted)[k] = Detect(image, expected[k]);
  return true;
} catch (const std::exception&) {
  sighted->clear();
  return false;
}

// A window about the place, with one threshold for all of it.
SightedDot DotFinder::Detect(const cv::Mat& image, const ExpectedDot& expected) {
  const Eigen::Vector2d place = expected.place;
  const Eigen::Array2d reach = expected.extent.array() + expected.search + 1;
  const double far = 1e6;
  if (!(place.cwiseAbs().maxCoeff() < far && reach.abs().maxCoeff() < far)) return {};
  const int left = std::max(0, static_cast<int>(std::floor(place.x() - reach.x())));
  const int top = std::max(0, static_cast<int>(std::floor(place.y() - reach.y())));
  const int right = std::min(image.cols, static_cast<int>(std::ceil(place.x() + reach.x())) + 1);
  const int bottom = std::min(image.rows, static_cast<int>(std::ceil(place.y() + reach.y())) + 1);
  if (right - left < 3 || bottom - top < 3) return {};
  const cv::Mat window = image(cv::Rect(left, top, right - left, bottom - top));
  const auto [darkest, lightest] = Extremes(window);
  if (lightest - darkest < params_.limits.contrast_min) return {};
  const int threshold = (darkest + lightest + 1) / 2;
  std::fill(one_threshold_.begin(), one_threshold_.end(), static_cast<std::uint8_t>(threshold));
  labeller_.Begin(window.cols);
  for (int y = 0; y < window.rows; ++y) {
    DarkBits(window.ptr<std::uint8_t>(y), window.cols, one_threshold_.data(), bits_.data());
    labeller_.AddRow(y, bits_.data(), params_.tone == DotTone::kLight);
  }
  SightedDot nearest;
  double distance = expected.search;
  for (const Blob& blob : labeller_.Finish()) {
    if (TouchesEdge(blob, window)) continue;
    auto ellipse = EllipseOf(blob, params_.limits);
    if (!ellipse) continue;
    ellipse->centre += Eigen::Vector2d(left, top);
    const double off = (ellipse->centre - place).cwiseAbs().maxCoeff();
    if (!(off <= distance)) continue;
    const auto dot = RefineDot(image, *ellipse, threshold, params_.tone, params_.limits);
    if (!dot) continue;
    if (expected.area > 0 && !(dot->area < 2 * expected.area && dot->area > expected.area / 2)) {
      continue;
    }
    nearest = {true, *dot};
    distance = off;
  }
  return nearest;
}

DotTracker::DotTracker(std::vector<Eigen::Vector2d> layout, const Params& params)
    : params_(params), finder_(params.finder), array_(std::move(layout), params.array) {
  const Eigen::Vector2d unknown = Eigen::Vector2d::Constant(std::nan(""));
  areas_.assign(array_.size(), 0);
  dots_.assign(array_.size(), {});
  for (SightedDot& dot : dots_) dot.dot.centre = unknown;
  expected_.resize(array_.size());
  now_.resize(array_.size());
  flags_.resize(array_.size());
  strays_.resize(array_.size());
}

void DotTracker::Hint(std::vector<Eigen::Vector2d> places) {
  if (places.size() != array_.size()) places.clear();
  for (const Eigen::Vector2d& place : places) {
    if (!place.allFinite()) return;
  }
  places_ = std::move(places);
  found_ = false;
}

bool DotTracker::Process(const cv::Mat& image) noexcept try {
  for (SightedDot& dot : dots_) dot.seen = false;
  seen_ = 0;
  if (!found_) {
    found_ = SearchFirst(image);
    last_seen_ = seen_;
    return found_;
  }
  if (params_.search == Search::kNear) {
    SearchNear(image);
  } else {
    SearchEverywhere(image);
  }
  DropStrays();
  const int n = static_cast<int>(array_.size());
  pictures_missing_ = seen_ < n ? pictures_missing_ + 1 : 0;
  if (seen_ < kManyLost * last_seen_ || pictures_missing_ % kRecheck == kRecheck - 1) {
    if (finder_.Find(image, &all_)) Rematch();
  }
  found_ = seen_ >= std::max(3.0, params_.array.least_seen / 2 * n);
  last_seen_ = seen_;
  if (found_) ExpectTheMissing();
  return found_;
} catch (const std::exception&) {
  found_ = false;
  return false;
}

bool DotTracker::SearchFirst(const cv::Mat& image) {
  const DotTone first = finder_.params().tone;
  const DotTone other = first == DotTone::kDark ? DotTone::kLight : DotTone::kDark;
  for (const DotTone tone : {first, other}) {
    finder_.set_tone(tone);
    if (finder_.Find(image, &all_) && Rematch()) {
      ExpectTheMissing();
      return true;
    }
    if (!params_.any_tone) break;
  }
  finder_.set_tone(first);
  return false;
}

// Takes the array as it is found in all dots of the picture if that shows more of it than is seen.
bool DotTracker::Rematch() {
  if (static_cast<int>(all_.size()) <= seen_) return false;
  const int matched = array_.Match(all_, places_, &picks_);
  if (matched <= seen_) return false;
  Take(picks_);
  Start();
  return true;
}

void DotTracker::SearchNear(const cv::Mat& image) {
  for (std::size_t k = 0; k < array_.size(); ++k) {
    ExpectedDot& expected = expected_[k];
    expected.place = places_[k];
    expected.extent = Extent(dots_[k].dot);
    expected.area = areas_[k];
    expected.search = kSearch * array_.Spacing(k, places_);
  }
  if (!finder_.Track(image, expected_, &dots_sighted_)) return;
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (dots_sighted_[k].seen) Accept(k, dots_sighted_[k].dot);
  }
}

void DotTracker::SearchEverywhere(const cv::Mat& image) {
  if (!finder_.Find(image, &all_)) return;
  array_.Follow(all_, places_, areas_, &picks_);
  Take(picks_);
}

void DotTracker::Take(std::span<const int> picks) {
  for (SightedDot& dot : dots_) dot.seen = false;
  seen_ = 0;
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (picks[k] >= 0) Accept(k, all_[Index(picks[k])]);
  }
}

void DotTracker::Accept(std::size_t k, const Dot& dot) {
  dots_[k] = {true, dot};
  areas_[k] = dot.area;
  ++seen_;
}

// The array was matched: from here its dots' moves are counted.
void DotTracker::Start() {
  places_.resize(array_.size());
  start_.resize(array_.size());
  double area = 0;
  Eigen::Matrix2d shape = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < array_.size(); ++k) {
    flags_[k] = dots_[k].seen ? 1 : 0;
    now_[k] = dots_[k].dot.centre;
    if (dots_[k].seen) area += dots_[k].dot.area / seen_, shape += dots_[k].dot.shape / seen_;
  }
  // Those not there are put where the layout and their neighbours say.
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (flags_[k] == 0) {
      now_[k] = array_.Expect(k, array_.layout(), now_, flags_);
      areas_[k] = params_.array.area_ratio < 10 ? area : 0;
      dots_[k].dot.shape = shape;
    }
    start_[k] = places_[k] = now_[k];
  }
}

// A dot that is not where its neighbours put it is another thing.
void DotTracker::DropStrays() {
  for (std::size_t k = 0; k < array_.size(); ++k) {
    flags_[k] = dots_[k].seen ? 1 : 0;
    now_[k] = dots_[k].dot.centre;
  }
  if (seen_ < 4) return;
  for (std::size_t k = 0; k < array_.size(); ++k) {
    strays_[k] = 0;
    if (flags_[k] == 0) continue;
    const Eigen::Vector2d put = array_.Expect(k, start_, now_, flags_);
    const double reach = std::max(kStrayFloor, kStray * array_.Spacing(k, start_));
    strays_[k] = (now_[k] - put).norm() <= reach ? 0 : 1;
  }
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (strays_[k] == 0) continue;
    dots_[k].seen = false;
    --seen_;
  }
}

void DotTracker::ExpectTheMissing() {
  for (std::size_t k = 0; k < array_.size(); ++k) {
    flags_[k] = dots_[k].seen ? 1 : 0;
    now_[k] = dots_[k].dot.centre;
  }
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (flags_[k] == 0) dots_[k].dot.centre = array_.Expect(k, start_, now_, flags_);
    places_[k] = dots_[k].dot.centre;
  }
}

}  // namespace palpate
