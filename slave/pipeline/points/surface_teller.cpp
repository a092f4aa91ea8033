#include "slave/pipeline/points/surface_teller.h"

#include <algorithm>

#include "slave/mechanics/make_model.h"
#include "slave/pipeline/points/surface_point_tracker.h"

namespace palpate {

bool EstimatesForce(const Scene& scene) {
  return IsHeld(scene.object) && scene.tool.has_value();
}

SurfaceTeller::SurfaceTeller(const Scene& scene)
    : is_depth_(scene.sense.depth.has_value()), not_found_(WhyNotFound(scene)) {
  if (EstimatesForce(scene)) {
    estimator_ = std::make_unique<SurfaceEstimator>(scene);
    reason_ = ChooseModel(scene).reason;
  } else {
    reason_ = "the object is followed, nothing presses it: no force is told";
  }
}

const ContactEstimate& SurfaceTeller::Feel(const SurfaceObservation& seen, bool rest_known,
                                           const Eigen::Vector3d& p_S_tip) noexcept {
  if (!rest_known) {
    before_rest_.sequence = seen.sequence;
    before_rest_.sensed_at = seen.sensed_at;
    before_rest_.p_S_tip = before_rest_.p_S_contact = p_S_tip;
    felt_ = &before_rest_;
    // The cells of a depth picture are not known before the rest frame.
    sees_rest_ = is_depth_ || std::ranges::any_of(seen.points, &SurfacePoint::seen);
  } else if (estimator_) {
    felt_ = &estimator_->Feel(seen, p_S_tip);
  } else {
    felt_ = &place_.Feel(seen);
  }
  return *felt_;
}

void SurfaceTeller::Reset() noexcept {
  if (estimator_) estimator_->Reset();
  place_.Reset();
}

std::string_view SurfaceTeller::why() const {
  if (felt_ == &before_rest_) return sees_rest_ ? "the rest frame is taken" : not_found_;
  if (felt_->validity == Validity::kValid) return {};
  if (felt_->validity == Validity::kTrackingLost) return "the points are not seen";
  return estimator_ ? estimator_->load().why : "nothing holds the object: its force is unknown";
}

ModelInfo SurfaceTeller::info() const {
  if (estimator_) return estimator_->body().info();
  ModelInfo none;
  none.kind = "none";
  return none;
}

LatencyHistogram SurfaceTeller::mechanics() const {
  return estimator_ ? estimator_->times().mechanics : LatencyHistogram{};
}

}  // namespace palpate
