#include "master/haptics/delayed_linear.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr double kLowering = 0.01;  // of the transport delay [s/s]

}  // namespace

void DelayedLinear::Add(double stamp, double arrival, const Eigen::Vector3d& force) noexcept {
  if (count_ > 0 && !(stamp > samples_[0].stamp)) return;
  const double lowered = count_ > 0 ? transport_ - kLowering * (stamp - samples_[0].stamp) : 0;
  transport_ = std::max({0.0, lowered, arrival - stamp});
  std::move_backward(samples_.begin(), samples_.end() - 1, samples_.end());
  samples_[0] = {stamp, force};
  count_ = std::min(count_ + 1, kKept);
}

Eigen::Vector3d DelayedLinear::At(double now) const noexcept {
  if (count_ < 2) return samples_[0].force;
  const double shown = now - (samples_[0].stamp - samples_[1].stamp) - transport_;
  if (shown >= samples_[0].stamp) return samples_[0].force;
  for (int i = 1; i < count_; ++i) {
    const Sample& from = samples_[static_cast<std::size_t>(i)];
    const Sample& to = samples_[static_cast<std::size_t>(i) - 1];
    if (shown < from.stamp) continue;
    const double share = (shown - from.stamp) / (to.stamp - from.stamp);
    return from.force + share * (to.force - from.force);
  }
  return samples_[static_cast<std::size_t>(count_) - 1].force;
}

}  // namespace palpate
