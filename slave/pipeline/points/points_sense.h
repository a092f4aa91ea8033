// Sensing with points on the object that a stereo pair or depth camera measures (paper C): dots,
// texture or the surface itself.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/state/slave_state.h"
#include "slave/capture/frame_source.h"
#include "slave/checks/points/points_limits.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/points/points_overlay.h"
#include "slave/pipeline/points/surface_estimator.h"
#include "slave/pipeline/points/surface_point_tracker.h"

namespace palpate {

// Returns whether a force can be estimated: a tool touches an object with a fixed boundary. An
// object without one is only tracked.
bool EstimatesForce(const Scene& scene);

class PointsSense final : public SensingPipeline {
 public:
  // Opens the source, precomputes the model; the first pairs are the baseline; until it is known
  // the force is unknown. Throws the exceptions of MakeSensingPipeline.
  PointsSense(const Scene& scene, const SenseInputs& inputs);
  // Creates it with another source than the scene's.
  PointsSense(const Scene& scene, std::unique_ptr<StereoSource> source);

  // Throws std::runtime_error also if the first images do not fit the rig.
  bool Acquire(const std::stop_token& stop) override;
  void Process() noexcept override;
  const ContactEstimate& Estimate(const TipReading& encoders) noexcept override;
  LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept override {
    return estimator_ ? estimator_->LocalAt(p_S_tip) : estimate_->local_model;
  }
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept override {
    return estimator_ && estimator_->MakePatch(p_S_tip, patch);
  }
  [[nodiscard]] bool HasOutgrownPatch() const noexcept override { return false; }
  void LearnLaw(PatchLaw* law) noexcept override {
    if (estimator_) estimator_->LearnLaw(law);
  }
  [[nodiscard]] SurfaceMotion motion() const noexcept override { return {}; }
  // Triangles of the model's surface; without force estimation those of the scene's mesh, moved as
  // a rigid body.
  BoundaryShape Shape(const ShapeParts& parts) override;
  [[nodiscard]] std::string_view flag_reason() const override {
    return estimate_->validity == Validity::kExtrapolated ? why() : std::string_view();
  }
  // Returns the left image.
  [[nodiscard]] std::optional<OverlaidImage> Image(double full_scale) const override;
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                       Progress* progress) const override {
    return estimator_ ? MakeLoadIdentifier(changed, progress) : nullptr;
  }
  void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) override;
  void Reset(const std::function<bool()>& is_disengaged) override;
  [[nodiscard]] SenseInfo info() const override;
  [[nodiscard]] std::vector<StageTimes> Stages() const override;
  std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth* truth) override;
  [[nodiscard]] TactileInbox* inbox() override { return nullptr; }
  [[nodiscard]] ImageInbox* image_inbox() override { return nullptr; }
  [[nodiscard]] Time sensed_at() const override { return next_.sensed_at; }
  [[nodiscard]] std::optional<CameraHealth> health() const override { return source_->health(); }

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const StereoRig& rig() const { return rig_; }
  [[nodiscard]] const SurfacePointTracker& tracker() const { return *tracker_; }
  // Results of the last estimate.
  [[nodiscard]] const StereoPair& pair() const { return shown_; }
  [[nodiscard]] const SurfaceObservation& observation() const { return *seen_; }
  [[nodiscard]] const ContactEstimate& estimate() const { return *estimate_; }
  // Returns whether the baseline of the points is being measured, so no estimate is possible yet.
  [[nodiscard]] bool takes_rest() const { return estimate_ == &before_rest_ && sees_rest_; }
  // Why estimate() is not kValid, one clause; empty: it is.
  [[nodiscard]] std::string_view why() const;
  // Null: no force is estimated.
  [[nodiscard]] SurfaceEstimator* estimator() { return estimator_.get(); }

 private:
  [[nodiscard]] const ContactEstimate& EstimateContact(const TipReading& encoders) noexcept;
  // `p_S`: the surface's nodes as they are deformed.
  [[nodiscard]] DisplacementField FieldOf(const SurfaceMesh& surface,
                                          const std::vector<std::uint32_t>& triangles,
                                          const std::vector<Eigen::Vector3d>& p_S) const;

  Scene scene_;
  std::unique_ptr<StereoSource> source_;
  StereoRig rig_;
  std::unique_ptr<SurfacePointTracker> tracker_;
  std::unique_ptr<SurfaceEstimator> estimator_;
  RigidTranslation place_;  // replaces the estimator if no force is estimated
  SurfaceMesh followed_;    // frame O; empty if a force is estimated or the scene has no mesh
  std::vector<std::uint32_t> held_;  // nodes of the estimator's surface
  ContactEstimate before_rest_;
  bool sees_rest_ = false;
  const ContactEstimate* estimate_ = &before_rest_;

  StereoPair next_;          // acquired
  bool rest_known_ = false;  // estimate before the rest shape is known
  const SurfaceObservation* seen_ = nullptr;
  double look_us_ = 0;
  struct Times {
    LatencyHistogram look, checks, total;
  } times_;  // per pair

  StereoPair shown_;  // of the last estimate
  PointsOverlay overlay_;
};

}  // namespace palpate
