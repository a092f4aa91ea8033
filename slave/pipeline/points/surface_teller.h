// What is told of an observation of the surface: the force where the scene has a model for it, else
// the place alone.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "slave/pipeline/points/rigid_translation.h"
#include "slave/pipeline/points/surface_estimator.h"
#include "slave/scene/scene.h"

namespace palpate {

// Whether a force can be told: a tool presses an object that something holds. What moves as a whole
// is followed only.
bool EstimatesForce(const Scene& scene);

// One thread at a time.
class SurfaceTeller {
 public:
  // Precomputes the model. Throws as SurfaceEstimator does.
  explicit SurfaceTeller(const Scene& scene);
  SurfaceTeller(const SurfaceTeller&) = delete;  // it refers to a part of itself
  SurfaceTeller& operator=(const SurfaceTeller&) = delete;

  // `rest_known`: the eyes knew the rest frame before they saw this; until then the force is
  // unknown, kFailed. Never throws.
  const ContactEstimate& Feel(const SurfaceObservation& seen, bool rest_known,
                              const Eigen::Vector3d& p_S_tip) noexcept;
  void Reset() noexcept;

  [[nodiscard]] const ContactEstimate& felt() const { return *felt_; }
  // Whether the eyes saw what they take the rest frame from when felt() was told, and nothing else
  // can be told yet.
  [[nodiscard]] bool takes_rest() const { return felt_ == &before_rest_ && sees_rest_; }
  // Why felt() is not kValid, one clause; empty: it is.
  [[nodiscard]] std::string_view why() const;
  // Null: no force is told.
  [[nodiscard]] SurfaceEstimator* estimator() { return estimator_.get(); }
  [[nodiscard]] const SurfaceEstimator* estimator() const { return estimator_.get(); }
  // What stands for the estimator where no force is told.
  [[nodiscard]] const RigidTranslation& place() const { return place_; }
  // Of the model; kind `none` where no force is told.
  [[nodiscard]] ModelInfo info() const;
  // Why this model, in a sentence.
  [[nodiscard]] std::string reason() const { return reason_; }
  [[nodiscard]] LatencyHistogram mechanics() const;

 private:
  std::unique_ptr<SurfaceEstimator> estimator_;
  std::string reason_;
  bool is_depth_ = false;
  std::string_view not_found_;
  RigidTranslation place_;
  ContactEstimate before_rest_;
  bool sees_rest_ = false;
  const ContactEstimate* felt_ = &before_rest_;
};

}  // namespace palpate
