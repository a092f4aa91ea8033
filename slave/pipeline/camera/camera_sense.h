// Sensing with one camera that sees the tool and the object's outline (paper A).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/capture/frame_source.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/camera/estimator.h"

namespace palpate {

class CameraSense final : public SensingPipeline {
 public:
  // Opens the source, finds tool and object in the first image, precomputes the model. Throws as
  // MakeSensingPipeline does.
  explicit CameraSense(const Scene& scene, const SenseInputs& inputs = {});

  bool Acquire(const std::stop_token& stop) override;
  void Process() noexcept override {
    if (!IsRestartDue()) observation_ = estimator_->See(next_);
  }
  const ContactEstimate& Estimate(const TipReading& encoders) noexcept override;
  [[nodiscard]] std::string_view flag_reason() const override { return estimator_->flag_reason(); }
  LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept override;
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept override {
    return estimator_->MakePatch(p_S_tip - motion().offset, patch);
  }
  [[nodiscard]] bool HasOutgrownPatch() const noexcept override { return false; }
  void LearnLaw(PatchLaw* /*law*/) noexcept override {}
  [[nodiscard]] SurfaceMotion motion() const noexcept override { return estimator_->motion(); }
  // Vertices of the boundary. Forces of the tool act on the two vertices at the contact point.
  BoundaryShape Shape(const ShapeParts& parts) override;
  [[nodiscard]] std::optional<OverlaidImage> Image(double full_scale) const override;
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                       Progress* progress) const override;
  void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) override;
  // Measures tip, template and rest edge again in the next image in which the tool is clear of the
  // object, wherever that is. If that fails, the old ones stay and health() states why. It tries
  // one image each second, ten in all.
  void Reset(const std::function<bool()>& is_disengaged) override;
  // The last estimate, for the present pose of the object.
  [[nodiscard]] const ContactEstimate& estimate() const { return estimate_; }
  [[nodiscard]] SenseInfo info() const override;
  [[nodiscard]] std::vector<StageTimes> Stages() const override;
  std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth* truth) override;
  [[nodiscard]] TactileInbox* inbox() override { return nullptr; }
  [[nodiscard]] ImageInbox* image_inbox() override { return nullptr; }
  [[nodiscard]] Time sensed_at() const override { return next_.sensed_at; }
  [[nodiscard]] std::optional<CameraHealth> health() const override;

  [[nodiscard]] const Estimator& estimator() const { return *estimator_; }
  // Results of the last estimate.
  [[nodiscard]] const Frame& frame() const { return seen_; }

 private:
  // Returns whether the baseline must be measured again in the acquired image.
  [[nodiscard]] bool IsRestartDue() const noexcept;
  // Measures the rest state in the last image.
  void Restart() noexcept;
  // Throws std::logic_error if an operator has engaged since Reset.
  void RequireDisengaged() const;
  // Throws the exceptions of Estimator.
  [[nodiscard]] std::shared_ptr<Estimator> MeasureRestState() const;
  void ReportTrouble(const std::string& trouble);
  // Returns the displacement field of the last estimate on the mesh of the outline.
  [[nodiscard]] DisplacementField Field();

  Scene scene_;  // with the active model
  std::unique_ptr<FrameSource> source_;
  Frame next_, seen_;     // next_: acquired; seen_: image of the last estimate
  bool is_first_ = true;  // next_ is still the first image
  std::optional<CameraObservation> observation_;  // of next_, until its estimate
  // State of a new measurement of the rest state.
  struct Restarting {
    Eigen::Isometry3d X_SO;  // pose of the object in the image before
    std::function<bool()> is_disengaged;
    int tries = 0;
    Time tried_at{};  // time of the last tried image
  };
  std::optional<Restarting> restarting_;
  Eigen::Vector3d p_S_encoders_{0, 0, 0};  // at the last estimate [m]
  double pixel_;                           // [m]
  Plane plane_;
  std::string reason_;
  const bool solves_aside_;                 // see SenseInputs
  mutable PriorityInheritanceMutex mutex_;  // guards `trouble_`, and the pointer for Prepare
  std::shared_ptr<Estimator> estimator_;
  std::string trouble_;  // why the rest state is not measured again; empty: it is
  ContactEstimate estimate_;
  std::optional<std::uint32_t> encoder_frame_;  // of the last reading
};

}  // namespace palpate
