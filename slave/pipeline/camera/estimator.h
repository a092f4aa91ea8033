// From one image to one contact estimate: frame -> observation -> contact -> response. Only this
// class combines images and forces.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/frame_source.h"
#include "slave/checks/camera/camera_checks.h"
#include "slave/contact/boundary_contact.h"
#include "slave/pipeline/base/estimate_builder.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/camera/first_picture.h"
#include "slave/pipeline/camera/indentation_forecast.h"
#include "slave/pipeline/camera/object_registration_monitor.h"
#include "slave/pipeline/camera/puncture_cue.h"
#include "slave/pipeline/camera/touch_model.h"
#include "slave/pipeline/manipulator_agreement/manipulator_agreement.h"
#include "slave/scene/scene.h"
#include "slave/vision/observation.h"
#include "slave/vision/tip_and_contour_tracker.h"

namespace palpate {

// Times per image.
struct StageHistograms {
  LatencyHistogram vision, checks, contact, mechanics, total;
};

// One thread at a time.
class Estimator {
 public:
  // `first`: an image of the object at rest. `p_S_tip_reported`: tip position from the encoders.
  // Throws std::runtime_error or std::invalid_argument naming what cannot be used: see
  // TipAndContourTracker, MakeModel.
  Estimator(const Scene& scene, const Frame& first,
            std::optional<Eigen::Vector3d> p_S_tip_reported);
  ~Estimator();

  // Tracks the tip in an image. Touches nothing that the other functions share with
  // Estimate: other threads may call them meanwhile.
  void Look(const Frame& frame) noexcept;
  // Tracks the tip unless Look did. Never throws; unknown values are flagged. The estimate
  // is relative to the object at rest: `motion` is the object's motion.
  const ContactEstimate& Estimate(const Frame& frame,
                                  const std::optional<EncoderReading>& said = {}) noexcept;
  // The plane that the master renders for a tip at p_S_tip [m] now, also between images: before
  // contact at the nearest point of the outline; it is fixed during a contact.
  LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // The outline around the tip and its compliance, see SensingPipeline::MakePatch.
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept;
  // Precomputes a replacement for `scene`'s model options; may be called from another thread.
  // Throws like the constructor.
  [[nodiscard]] std::unique_ptr<TouchModel> Prepare(const Scene& scene,
                                                    Progress* progress = nullptr) const;
  // Activates it; a contact continues from the point where it began.
  void Adopt(std::unique_ptr<TouchModel> touch, const Scene& scene);
  // Resets tracker and contact.
  void Reset() noexcept;

  [[nodiscard]] const ContactEstimate& felt() const { return felt_; }
  [[nodiscard]] const TipAndContourTracker& tracker() const { return *tracker_; }
  [[nodiscard]] const CameraView& view() const { return view_; }
  [[nodiscard]] const Registration& registration() const { return registration_; }
  [[nodiscard]] TouchModel& touch() { return *touch_; }
  [[nodiscard]] const TouchModel& touch() const { return *touch_; }
  [[nodiscard]] const Observation& observation() const { return *observation_; }
  // Motion of the object since the first image, S; zero if the camera moves, or if the tool
  // position is unknown.
  [[nodiscard]] const SurfaceMotion& motion() const { return agreement_.motion(); }
  // Pose of the object as the last image shows it, X_SO: a motion of the camera moves it too.
  [[nodiscard]] Eigen::Isometry3d ApparentPose() const;
  // For the last image; null: the scene tracks no contour, so nothing checks the tip.
  [[nodiscard]] const ObjectSighting* sighting() const {
    return watch_ ? &watch_->sighting() : nullptr;
  }
  [[nodiscard]] const StageHistograms& times() const { return times_; }
  // Shown with the last estimate [px].
  [[nodiscard]] Curve shown_contour_I() const { return watch_ ? watch_->Edge() : Curve(); }
  [[nodiscard]] cv::Rect shown_window() const { return shown_window_; }
  [[nodiscard]] const TipObservation& shown_tip() const { return shown_tip_; }

 private:
  void ResumeContact() noexcept;
  Eigen::Vector2d CompensatedTip(const TipObservation& tip) noexcept;
  void CompareWithEncoders(const Eigen::Vector3d& p_S_tip,
                           const std::optional<EncoderReading>& said) noexcept;
  void ProcessObject(const cv::Mat& image) noexcept;
  [[nodiscard]] double DepthOf(const Eigen::Vector2d& dent_O) const noexcept;
  void DetectPuncture(double depth) noexcept;
  // False: the model has no solution.
  bool Touch(const Eigen::Vector3d& p_S_tip) noexcept;
  [[nodiscard]] double GapSigma(const BoundaryPlace& place) const noexcept;
  void ExpectDent(const BoundaryPlace& place) noexcept;
  void UpdateLocalModel(const BoundaryPlace& place, const ContactResponse& response) noexcept;

  CameraView view_;
  std::unique_ptr<TipAndContourTracker> tracker_;
  Registration registration_;
  std::unique_ptr<TouchModel> touch_;
  std::optional<ObjectRegistrationMonitor> watch_;
  ManipulatorAgreement agreement_;
  ObjectRegistrationMonitor::Bar tool_;  // in the last image
  IndentationForecast dent_;
  Eigen::Vector2d dent_O_{0, 0};  // expected in the last image [px]
  double tip_sigma_ = 0;          // including the compensated image motion [px]
  Eigen::Matrix2d tip_covariance_ = Eigen::Matrix2d::Zero();  // of the same [px^2]
  Checks<CameraSample> checks_;
  double checks_us_ = 0;                 // in this image
  BoundaryPlace pressed_place_;          // that the model answered last for the tool
  Eigen::Vector3d pressed_by_{0, 0, 0};  // displacement there, frame O [m]
  EstimateBuilder rules_;
  PunctureCue cue_;
  const Observation* observation_ = nullptr;  // in the image of Look
  std::optional<std::uint64_t> looked_at_;    // sequence number of that image, until its estimate
  ContactEstimate felt_;
  cv::Rect shown_window_;
  TipObservation shown_tip_;
  double look_us_ = 0;
  StageHistograms times_;
};

}  // namespace palpate
