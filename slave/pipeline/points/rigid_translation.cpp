#include "slave/pipeline/points/rigid_translation.h"

namespace palpate {

void RigidTranslation::Start(const SurfaceObservation& seen) noexcept {
  first_.assign(seen.points.size(), 0);
  p_S_rest_.setZero();
  int count = 0;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    if (!seen.points[i].seen) continue;
    first_[i] = 1;
    p_S_rest_ += seen.points[i].p_S_rest;
    ++count;
  }
  if (count > 0) p_S_rest_ /= count;
}

const ContactEstimate& RigidTranslation::Feel(const SurfaceObservation& seen) noexcept {
  felt_.sample = seen.sequence;
  felt_.sensed_at = seen.sensed_at;
  felt_.events.Clear();
  if (first_.size() != seen.points.size() && seen.found) Start(seen);
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  int count = 0;
  for (std::size_t i = 0; seen.found && i < seen.points.size(); ++i) {
    const SurfacePoint& point = seen.points[i];
    if (!point.seen || !first_[i] || !point.p_S.allFinite()) continue;
    moved += point.p_S - point.p_S_rest;
    ++count;
  }
  if (count > 0) {
    moved_ = moved / count;
    felt_.p_S_tip = felt_.p_S_contact = p_S_rest_ + moved_;
  }
  const Validity validity = count > 0 ? Validity::kFailed : Validity::kTrackingLost;
  if (validity != felt_.validity) {
    felt_.events.Add(count > 0 ? Event::kTrackingRegained : Event::kTrackingLost);
  }
  felt_.validity = validity;
  return felt_;
}

}  // namespace palpate
