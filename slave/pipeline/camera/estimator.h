// One picture in, one felt state out: frame -> observation -> contact -> response. One direction,
// no back and forth; the only place that knows both pictures and forces.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/frame_source.h"
#include "slave/contact/boundary_contact.h"
#include "slave/pipeline/arm_consistency_check.h"
#include "slave/pipeline/camera/first_picture.h"
#include "slave/pipeline/camera/frozen_picture.h"
#include "slave/pipeline/camera/indentation_check.h"
#include "slave/pipeline/camera/moving_object.h"
#include "slave/pipeline/camera/object_registration_monitor.h"
#include "slave/pipeline/camera/puncture_cue.h"
#include "slave/pipeline/camera/touch_model.h"
#include "slave/pipeline/estimate_builder.h"
#include "slave/pipeline/sensing_pipeline.h"
#include "slave/scene/scene.h"
#include "slave/vision/interlace_detector.h"
#include "slave/vision/observation.h"
#include "slave/vision/tip_and_contour_tracker.h"

namespace palpate {

// Times per picture.
struct StageHistograms {
  LatencyHistogram vision, checks, contact, mechanics, total;
};

// One thread at a time.
class Estimator {
 public:
  // `first`: a picture in which the object rests. `p_S_tip_reported`: where the manipulator says
  // the tip is. Throws std::runtime_error or std::invalid_argument naming what cannot be used: see
  // TipAndContourTracker, MakeModel.
  Estimator(const Scene& scene, const Frame& first,
            std::optional<Eigen::Vector3d> p_S_tip_reported);
  ~Estimator();

  // Never throws; what cannot be known is flagged. As if the object had not moved: `motion` says
  // how far it has.
  const ContactEstimate& Estimate(const Frame& frame,
                                  const std::optional<EncoderReading>& said = {}) noexcept;
  // The contact that the master renders for a tip at p_S_tip [m] now, between pictures too: before
  // it touches, the plane at the nearest place of the outline; that plane stays from where the tip
  // comes in until it has come out.
  LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // The outline around the tip and how it gives way, see SensingPipeline::MakePatch.
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept;
  // Precomputes a replacement for `scene`'s model options; may be called from another thread.
  // Throws like the constructor.
  [[nodiscard]] std::unique_ptr<TouchModel> Prepare(const Scene& scene,
                                                    Progress* progress = nullptr) const;
  // Puts it to work; a contact goes on from the place where it began.
  void Adopt(std::unique_ptr<TouchModel> touch, const Scene& scene);
  // Tracker and contact start anew.
  void Reset() noexcept;

  [[nodiscard]] const ContactEstimate& felt() const { return felt_; }
  [[nodiscard]] const TipAndContourTracker& eyes() const { return *eyes_; }
  [[nodiscard]] const CameraView& view() const { return view_; }
  [[nodiscard]] const Registration& registration() const { return registration_; }
  [[nodiscard]] TouchModel& touch() { return *touch_; }
  [[nodiscard]] const TouchModel& touch() const { return *touch_; }
  [[nodiscard]] const Observation& observation() const { return *observation_; }
  // Of the object since the first picture, S; none where what moves is the camera, or where nobody
  // says where the tool is.
  [[nodiscard]] const SurfaceMotion& motion() const { return object_.motion(); }
  // Of the last picture; null: the scene follows no contour, so that nothing checks the tip.
  [[nodiscard]] const ObjectSighting* sighting() const {
    return watch_ ? &watch_->sighting() : nullptr;
  }
  [[nodiscard]] const StageHistograms& times() const { return times_; }

 private:
  void ResumeContact() noexcept;
  // What the object's edge measured goes to the details.
  void ReportSighting() noexcept;
  Eigen::Vector2d CompensatedTip(const TipObservation& tip) noexcept;
  bool CompareWithEncoders(const Eigen::Vector3d& p_S_tip, const EncoderReading& said) noexcept;
  void FollowObject(const EncoderReading& said) noexcept;
  void ProcessObject(const cv::Mat& image) noexcept;
  [[nodiscard]] double DepthOf(const Eigen::Vector2d& dent_O) const noexcept;
  void DetectPuncture(double depth) noexcept;
  void Touch(const Eigen::Vector3d& p_S_tip) noexcept;
  [[nodiscard]] double GapSigma(const BoundaryPlace& place) const noexcept;
  void ExpectDent(const BoundaryPlace& place) noexcept;
  void CheckIndentation(const Eigen::Vector2d& dent_O) noexcept;
  void UpdateLocalModel(const BoundaryPlace& place, const ContactResponse& response) noexcept;

  CameraView view_;
  std::unique_ptr<TipAndContourTracker> eyes_;
  Registration registration_;
  std::unique_ptr<TouchModel> touch_;
  std::optional<ObjectRegistrationMonitor> watch_;
  ArmConsistencyCheck arm_in_picture_,
      arm_on_object_;  // one parts where the camera moves, one the object
  MovingObject object_;
  ObjectRegistrationMonitor::Bar tool_;  // in the last picture
  IndentationCheck dent_;
  Eigen::Vector2d dent_O_{0, 0};  // expected, of the last picture [px]
  double tip_sigma_ = 0;          // with that of the picture's motion [px]
  Eigen::Matrix2d tip_covariance_ = Eigen::Matrix2d::Zero();  // of the same [px^2]
  Eigen::Vector3d parting_{0, 0, 0};  // of eyes and arm, that nothing explains, S [m]
  int regained_ = 0;                  // pictures until what was lost and is seen again is believed
  FrozenPicture last_;
  InterlaceDetector comb_;
  FailedCheck tool_doubt_ = FailedCheck::kNone;  // of the tool in the first picture
  bool is_noisy_ = false;                        // the first picture has noise
  double checks_us_ = 0;                         // of this picture
  BoundaryPlace pressed_place_;                  // that the model answered last for the tool
  Eigen::Vector3d pressed_by_{0, 0, 0};          // displacement there, frame O [m]
  EstimateBuilder rules_;
  PunctureCue cue_;
  const Observation* observation_ = nullptr;
  ContactEstimate felt_;
  StageHistograms times_;
};

}  // namespace palpate
