#include "master/haptics/render_fallback_selector.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kTick = 0.002;  // largest distance from a stored tick [s]
constexpr double kNoise = 2;     // sigmas within noise
constexpr double kBetter = 1;  // ratio of mean squares (model / hold) that selects the model again

}  // namespace

void RenderFallbackSelector::Show(double now, const Eigen::Vector3d& model,
                                  const Eigen::Vector3d& held) noexcept {
  shown_[count_ % kTicks] = {now, model.cast<float>(), held.cast<float>()};
  ++count_;
}

const RenderFallbackSelector::Shown* RenderFallbackSelector::Find(double at) const noexcept {
  std::size_t low = count_ > kTicks ? count_ - kTicks : 0, high = count_;
  while (low < high) {  // the first one later than `at`
    const std::size_t middle = low + (high - low) / 2;
    if (shown_[middle % kTicks].at > at) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  if (low == 0) return nullptr;
  const Shown& shown = shown_[(low - 1) % kTicks];
  return shown.at <= at && at - shown.at <= kTick ? &shown : nullptr;
}

Eigen::Vector3d RenderFallbackSelector::Compare(double commanded, const Eigen::Vector3d& estimated,
                                                double sigma) noexcept {
  const Shown* shown = Find(commanded);
  if (shown == nullptr || !estimated.allFinite()) return {0, 0, 0};
  const auto error = [&](const Eigen::Vector3d& rendered) {
    return std::max(0.0,
                    (rendered - estimated).norm() - kNoise * sigma - kTolerated * estimated.norm());
  };
  while (first_ < end_ &&
         (end_ - first_ == kWaiting || commanded - waiting_[first_ % kWaiting].at > kLag)) {
    Count(waiting_[first_++ % kWaiting]);
  }
  for (std::size_t i = first_; i < end_; ++i) {
    Sample& sample = waiting_[i % kWaiting];
    sample.of_model = std::min(sample.of_model, error(sample.model));
  }
  const Eigen::Vector3d model = shown->model.cast<double>();
  waiting_[end_++ % kWaiting] = {commanded, model, error(model), error(shown->held.cast<double>())};
  return estimated - model;
}

void RenderFallbackSelector::Count(const Sample& sample) noexcept {
  if (sample.of_model == 0 && sample.of_hold == 0) return;  // no contact, or no error
  const double keep = std::exp(-std::clamp(sample.at - last_, 0.0, kMemory) / kMemory);
  last_ = sample.at;
  of_model_ = keep * of_model_ + sample.of_model * sample.of_model;
  of_hold_ = keep * of_hold_ + sample.of_hold * sample.of_hold;
  weight_ = keep * weight_ + 1;
  if (weight_ < kEnough) return;
  prefers_hold_ = of_model_ > (prefers_hold_ ? kBetter : kWorse) * of_hold_;
}

}  // namespace palpate
