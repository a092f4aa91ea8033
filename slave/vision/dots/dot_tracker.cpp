#include "slave/vision/dots/dot_tracker.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <utility>

namespace palpate {
namespace {

constexpr int kRecheck = 8;         // pictures with a dot missing between two whole searches
constexpr double kManyLost = 0.85;  // less than so much of the last picture's dots
constexpr double kSearch = 0.4;     // how far a dot is looked for, in spacings
constexpr double kStray = 0.25;     // how far a dot may be from where its neighbours put it
constexpr double kStrayFloor = 3;   // but never less [px]

Eigen::Vector2d Extent(const Dot& dot) {
  return {2 * std::sqrt(dot.shape(0, 0)), 2 * std::sqrt(dot.shape(1, 1))};
}

}  // namespace

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

bool DotTracker::Look(const cv::Mat& image) noexcept try {
  for (SightedDot& dot : dots_) dot.seen = false;
  seen_ = 0;
  if (!found_) {
    found_ = LookAnew(image);
    last_seen_ = seen_;
    return found_;
  }
  if (params_.search == Search::kNear) {
    LookNear(image);
  } else {
    LookEverywhere(image);
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

bool DotTracker::LookAnew(const cv::Mat& image) {
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

void DotTracker::LookNear(const cv::Mat& image) {
  for (std::size_t k = 0; k < array_.size(); ++k) {
    ExpectedDot& expected = expected_[k];
    expected.place = places_[k];
    expected.extent = Extent(dots_[k].dot);
    expected.area = areas_[k];
    expected.search = kSearch * array_.Spacing(k, places_);
  }
  if (!finder_.Track(image, expected_, &dots_sighted_)) return;
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (dots_sighted_[k].seen) See(k, dots_sighted_[k].dot);
  }
}

void DotTracker::LookEverywhere(const cv::Mat& image) {
  if (!finder_.Find(image, &all_)) return;
  array_.Follow(all_, places_, areas_, &picks_);
  Take(picks_);
}

void DotTracker::Take(std::span<const int> picks) {
  for (SightedDot& dot : dots_) dot.seen = false;
  seen_ = 0;
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (picks[k] >= 0) See(k, all_[static_cast<std::size_t>(picks[k])]);
  }
}

void DotTracker::See(std::size_t k, const Dot& dot) {
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
