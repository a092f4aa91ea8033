#include "slave/vision/dots/dot_tracker.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "slave/mesh/index.h"

namespace palpate {
DotTracker::DotTracker(std::vector<Eigen::Vector2d> layout, std::vector<Eigen::Vector2d> projected,
                       const Params& params)
    : params_(params),
      finder_(params.finder),
      array_(std::move(layout)),
      projected_(std::move(projected)),
      places_(projected_),
      areas_(array_.size(), 0),
      dots_(array_.size()) {
  for (SightedDot& dot : dots_) dot.dot.centre.setConstant(std::nan(""));
}

bool DotTracker::Process(const cv::Mat& image) noexcept try {
  for (SightedDot& dot : dots_) dot.seen = false;
  seen_ = 0;
  found_ = found_ ? finder_.Find(image, &all_) && Search(places_, params_.min_seen / 2)
                  : SearchFirst(image);
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
    if (!finder_.Find(image, &all_)) break;
    if (Search(places_, params_.min_seen)) return true;
    if (Search(projected_, params_.min_seen)) return true;
    if (!params_.any_tone) break;
  }
  finder_.set_tone(first);
  return false;
}

// Assigns the dots of the image to dots of the array near `places`.
bool DotTracker::Search(std::span<const Eigen::Vector2d> places, double min_seen) {
  array_.Identify(all_, places, areas_, &picks_);
  seen_ = 0;
  for (std::size_t k = 0; k < array_.size(); ++k) {
    dots_[k].seen = picks_[k] >= 0;
    if (!dots_[k].seen) continue;
    dots_[k].dot = all_[Index(picks_[k])];
    ++seen_;
  }
  return seen_ >= std::max(3.0, min_seen * static_cast<double>(array_.size()));
}

void DotTracker::ExpectTheMissing() {
  std::vector<char> flags(array_.size());
  for (std::size_t k = 0; k < array_.size(); ++k) {
    flags[k] = dots_[k].seen ? 1 : 0;
    places_[k] = dots_[k].dot.centre;
  }
  const std::vector<Eigen::Vector2d> now = places_;
  for (std::size_t k = 0; k < array_.size(); ++k) {
    if (dots_[k].seen) {
      areas_[k] = dots_[k].dot.area;
    } else {
      places_[k] = dots_[k].dot.centre = array_.Expect(k, projected_, now, flags);
    }
  }
}

}  // namespace palpate
