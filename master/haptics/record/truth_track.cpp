#include "master/haptics/record/truth_track.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr double kLongestGap = 0.100;  // [s]

}  // namespace

void TruthTrack::Add(Time at, const Eigen::Vector3d& force_S) {
  if (!samples_.empty() && at <= samples_.back().at) return;
  samples_.push_back({at, force_S});
}

std::optional<Eigen::Vector3d> TruthTrack::At(Time t) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), t,
                                      [](const Sample& s, Time wanted) { return s.at < wanted; });
  if (after == samples_.end()) return std::nullopt;
  if (after->at == t) return after->force;
  if (after == samples_.begin()) return std::nullopt;
  const auto before = after - 1;
  const double gap = SecondsBetween(before->at, after->at);
  if (gap > kLongestGap) return std::nullopt;
  const double share = SecondsBetween(before->at, t) / gap;
  return before->force + share * (after->force - before->force);
}

void TruthTrack::DropBefore(Time t) {
  while (samples_.size() > 1 && samples_[1].at <= t) samples_.pop_front();
}

}  // namespace palpate
