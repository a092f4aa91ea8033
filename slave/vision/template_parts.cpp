#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include <opencv2/core.hpp>

#include "slave/vision/tip_tracker.h"

namespace palpate {
namespace {

constexpr double kPartWidth = 14, kPartHeight = 10;  // approximate size of a part [px]
constexpr int kMaxAcross = 4, kMaxAlong = 8;
// Smallest fraction of a part's pixels that the alignment trusts.
constexpr double kMinTrusted = 0.85;
// Smallest variance of a part relative to that of the whole template.
constexpr double kMinVariance = 0.15;
constexpr double kDifferenceStep = 2;  // step of the difference quotient along the tool [px]
constexpr std::size_t kMinParts = 4;   // parts
constexpr double kMinSignal = 0.25;    // part of the variance that is not noise
// Limit of a change in an image relative to the template's largest change.
constexpr double kMaxChange = 1.5;
constexpr int kSamePartPeak = 3;  // distance within which two peaks are one [px]
constexpr double kFits = 0.6;     // smallest score of a matching part

struct Cut {
  GreyPatch pixels;
  double trusted = 0;  // part of the pixels
};

void CutOut(const GreyPatch& from, const cv::Rect& box, GreyPatch& out) {
  out.Resize(box.width, box.height);
  for (int y = 0; y < box.height; ++y) {
    std::copy_n(from.Row(box.y + y) + box.x, box.width, out.Row(y));
  }
}

Cut CutOut(const TipTemplate& tip, const GreyPatch& change, const cv::Rect& box) {
  Cut cut;
  CutOut(change, box, cut.pixels);
  for (int y = 0; y < box.height; ++y) {
    const auto row = tip.weights.begin() + (box.y + y) * tip.pixels.width + box.x;
    cut.trusted += std::accumulate(row, row + box.width, 0.0) / box.area();
  }
  return cut;
}

int Pieces(int length, double wanted, int most) {
  return std::clamp(static_cast<int>(std::lround(length / wanted)), 1, most);
}

// Computes the difference over 2 `step` along the tool, clamped to `most` levels. At the border it
// uses the border's pixels.
void Differentiate(const GreyPatch& levels, const cv::Point& step, int most, GreyPatch& out) {
  out.Resize(levels.width, levels.height);
  const auto clamped = [](int i, int size) { return std::clamp(i, 0, size - 1); };
  for (int y = 0; y < levels.height; ++y) {
    const std::int16_t* ahead = levels.Row(clamped(y + step.y, levels.height));
    const std::int16_t* behind = levels.Row(clamped(y - step.y, levels.height));
    std::int16_t* to = out.Row(y);
    for (int x = 0; x < levels.width; ++x) {
      const int change =
          ahead[clamped(x + step.x, levels.width)] - behind[clamped(x - step.x, levels.width)];
      to[x] = static_cast<std::int16_t>(std::clamp(change, -most, most));
    }
  }
}

}  // namespace

TemplateParts::TemplateParts(const TipTemplate& tip)
    : width_(tip.pixels.width),
      height_(tip.pixels.height),
      step_(static_cast<int>(std::lround(kDifferenceStep * tip.along.x())),
            static_cast<int>(std::lround(kDifferenceStep * tip.along.y()))),
      trust_(height_ - 2, width_ - 2) {
  Differentiate(tip.pixels, step_, max_difference_, change_);
  // The border of the template is left out, because pixels beyond it are unknown.
  const cv::Point inset(std::abs(step_.x), std::abs(step_.y));
  const cv::Size inside(width_ - 2 * inset.x, height_ - 2 * inset.y);
  const bool wide = width_ > height_;  // the tool lies along the longer side
  const int columns = Pieces(inside.width, kPartWidth, wide ? kMaxAlong : kMaxAcross);
  const int rows = Pieces(inside.height, kPartHeight, wide ? kMaxAcross : kMaxAlong);
  const double least = kMinVariance * VarianceOf(change_);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const cv::Point from(i * inside.width / columns, j * inside.height / rows);
      const cv::Point to((i + 1) * inside.width / columns, (j + 1) * inside.height / rows);
      const cv::Rect box = cv::Rect(from, to) + inset;
      if (box.empty()) continue;
      Cut cut = CutOut(tip, change_, box);
      if (cut.trusted < kMinTrusted || !(VarianceOf(cut.pixels) > std::max(least, 1.0))) continue;
      parts_.push_back({box.tl(), Ncc(std::move(cut.pixels))});
    }
  }
  for (const Part& part : parts_) {
    variance_ += VarianceOf(part.ncc.pattern()) / static_cast<double>(parts_.size());
  }
  // A glint has a larger change than any mark; it must not outweigh the marks in its part.
  int largest = 0;
  for (const Part& part : parts_) {
    for (const int change : part.ncc.pattern().levels)
      largest = std::max(largest, std::abs(change));
  }
  max_difference_ = static_cast<int>(kMaxChange * largest);
  const double noise = NoiseOf(tip.pixels);
  signal_ = std::max(variance_ - 2 * noise * noise, kMinSignal * variance_);
  scores_.resize(parts_.size());
}

bool TemplateParts::usable() const {
  return parts_.size() >= kMinParts;
}

double TemplateParts::Attenuation(double noise) const {
  return signal_ / std::sqrt(variance_ * (signal_ + 2 * noise * noise));
}

// Returns the mean score of the better half of the parts. `score` returns the score of a part.
template <typename Score>
double TemplateParts::BetterHalf(const Score& score) {
  for (std::size_t k = 0; k < parts_.size(); ++k)
    scores_[k] = std::max<double>(0, score(parts_[k]));
  const auto half = static_cast<std::ptrdiff_t>((parts_.size() + 1) / 2);
  const auto middle = scores_.begin() + half;
  std::nth_element(scores_.begin(), middle - 1, scores_.end(), std::greater<>());
  return std::accumulate(scores_.begin(), middle, 0.0) / static_cast<double>(half);
}

TemplateParts::Place TemplateParts::Find(const GreyPatch& window) {
  Place place;
  const cv::Size size(window.width - width_ + 1, window.height - height_ + 1);
  if (size.width < 1 || size.height < 1 || !usable()) return place;
  Differentiate(window, step_, max_difference_, change_);
  for (Part& part : parts_) part.ncc.Match(change_);
  ScoreMap map(size);
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      map(y, x) = static_cast<float>(BetterHalf(
          [&](const Part& part) { return part.ncc.map()(y + part.corner.y, x + part.corner.x); }));
    }
  }
  cv::minMaxLoc(map, nullptr, &place.score, nullptr, &place.at);
  place.on_border = place.at.x == 0 || place.at.y == 0 || place.at.x == map.cols - 1 ||
                    place.at.y == map.rows - 1;
  const cv::Point reach(kSamePartPeak, kSamePartPeak);
  map(cv::Rect(place.at - reach, place.at + reach + cv::Point(1, 1)) & cv::Rect({}, size)) = 0;
  cv::minMaxLoc(map, nullptr, &place.second);
  MarkFitting(place.at);
  return place;
}

double TemplateParts::ScoreNear(const GreyPatch& window, const cv::Point& at) {
  const cv::Point reach(1 + std::abs(step_.x), 1 + std::abs(step_.y));
  const cv::Rect around = cv::Rect(at - reach, cv::Size(width_, height_) + cv::Size(2 * reach)) &
                          cv::Rect(0, 0, window.width, window.height);
  CutOut(window, around, crop_);
  Differentiate(crop_, step_, max_difference_, change_);
  double best = 0;
  for (int y = 0; y + height_ <= around.height; ++y) {
    for (int x = 0; x + width_ <= around.width; ++x) {
      best = std::max(best, BetterHalf([&](const Part& part) {
                        return part.ncc.At(change_, x + part.corner.x, y + part.corner.y);
                      }));
    }
  }
  return best;
}

void TemplateParts::MarkFitting(const cv::Point& at) {
  trust_ = 1;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const cv::Point& corner = parts_[k].corner;
    if (parts_[k].ncc.map()(at + corner) >= kFits) continue;
    const GreyPatch& pattern = parts_[k].ncc.pattern();
    const cv::Rect part(corner - cv::Point(1, 1), cv::Size(pattern.width, pattern.height));
    trust_(part & cv::Rect({}, trust_.size())) = 0;
  }
}

}  // namespace palpate
