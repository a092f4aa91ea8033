// The place of a moving object whose force nobody can tell, because the scene has no model of how
// it is touched: paper C's second experiment (5.2).
#pragma once

#include <vector>

#include "shared/state/slave_state.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// The points that the first observation shows stand for the object. Its place is their mean at
// rest, carried by the mean displacement of those that are seen: exact for a body that does not
// turn, whichever of them are hidden.
class RigidTranslation {
 public:
  // The place is told as tip and as contact. The force is unknown: kFailed while the object is
  // followed, kTrackingLost while it is not. Never throws; allocates in the first observation only.
  const ContactEstimate& Feel(const SurfaceObservation& seen) noexcept;
  void Reset() noexcept { first_.clear(); }
  [[nodiscard]] const ContactEstimate& felt() const { return felt_; }
  // From the place at rest [m]; while it is lost that of before.
  [[nodiscard]] const Eigen::Vector3d& moved() const { return moved_; }

 private:
  void Start(const SurfaceObservation& seen) noexcept;

  std::vector<char> first_;  // per point: in the first observation; empty: nothing was seen yet
  Eigen::Vector3d p_S_rest_{0, 0, 0}, moved_{0, 0, 0};
  ContactEstimate felt_;
};

}  // namespace palpate
