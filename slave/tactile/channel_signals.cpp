#include "slave/tactile/channel_signals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace palpate {
namespace {

constexpr double kBack = 0.3;  // remaining part of a jump at which the channel counts as recovered
// Ratio of a channel's ranges on both sides above which contacts move it to one side only.
constexpr double kOneSided = 3;

}  // namespace

ChannelSignals::ChannelSignals(std::shared_ptr<const ChannelPattern> pattern)
    : pattern_(std::move(pattern)) {
  x_ = last_ = residual_ = Eigen::VectorXd::Zero(pattern_->below.size());
  channels_.resize(static_cast<std::size_t>(x_.size()));
}

void ChannelSignals::Reset() noexcept {
  std::ranges::fill(channels_, Channel{});
  seen_ = 0;
  fault_ = {};
  is_beyond_ = is_opposite_ = false;
}

void ChannelSignals::Update(const TactileSignals& change) noexcept {
  x_ = Eigen::Map<const Eigen::VectorXd>(change.data(), x_.size());
  fault_ = {};
  CompareWithOthers();
  CompareWithRange();
  FindJumps();
  last_ = x_;
  seen_ = std::min(seen_ + 1, 2);
}

void ChannelSignals::CompareWithOthers() noexcept {
  const Eigen::Index n = x_.size();
  if (n < 2) return;
  residual_ = x_;
  residual_.noalias() -= pattern_->expectation * x_;
  const double square = x_.squaredNorm();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double others2 = (square - x_[i] * x_[i]) / static_cast<double>(n - 1);
    const double tolerance =
        std::hypot(pattern_->tolerance[i],
                   pattern_->relative_tolerance[i] * std::sqrt(std::max(others2, 0.0)));
    if (std::abs(residual_[i]) > tolerance) fault_ = "the channels do not match each other";
  }
}

void ChannelSignals::CompareWithRange() noexcept {
  is_beyond_ = is_opposite_ = false;
  for (Eigen::Index i = 0; i < x_.size(); ++i) {
    const double low = pattern_->below[i], high = pattern_->above[i];
    if (x_[i] < -low) (kOneSided * low < high ? is_opposite_ : is_beyond_) = true;
    if (x_[i] > high) (kOneSided * high < low ? is_opposite_ : is_beyond_) = true;
  }
}

void ChannelSignals::FindJumps() noexcept {
  for (Eigen::Index i = 0; i < x_.size(); ++i) {
    Channel& channel = channels_[static_cast<std::size_t>(i)];
    const double step = x_[i] - last_[i];
    const double surprise = std::abs(step - channel.pace);
    if (seen_ == 0) {
      channel.is_fresh = false;
    } else if (std::exchange(channel.is_fresh, false) && std::abs(step - channel.jump) < surprise) {
      channel.jump = 0;  // the change continues, so it is no jump
      channel.pace = step;
    } else if (seen_ == 2 && surprise > pattern_->second_difference[i]) {
      const bool is_back = std::abs(channel.jump + step) < kBack * std::abs(step);
      channel.jump = is_back ? 0 : step;
      channel.is_fresh = !is_back;
    } else {
      channel.pace = step;
    }
    if (std::abs(x_[i]) <= pattern_->tolerance[i]) channel.jump = 0;
    if (channel.jump != 0) fault_ = "a channel jumps, or changes faster than in the training";
  }
}

}  // namespace palpate
