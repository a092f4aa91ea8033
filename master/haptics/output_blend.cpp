#include "master/haptics/output_blend.h"

namespace palpate {

void OutputBlend::Go(Target target, double duration) noexcept {
  target_ = target;
  from_ = sent_;
  duration_ = duration;
  elapsed_ = 0;
}

Eigen::Vector3d OutputBlend::Step(const Eigen::Vector3d& rendered, double dt) noexcept {
  elapsed_ += dt;
  Eigen::Vector3d wanted(0, 0, 0);
  if (target_ == Target::kRendered) wanted = rendered;
  if (target_ == Target::kFrozen) wanted = from_;
  const double share = is_blending() ? elapsed_ / duration_ : 1;
  sent_ = from_ + share * (wanted - from_);
  if (share >= 1) sent_ = wanted;
  return sent_;
}

}  // namespace palpate
