// Computes one contact estimate from one image: frame -> observation -> contact -> response. Only
// this class combines images and forces.
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
#include "slave/pipeline/camera/indentation_forecast.h"
#include "slave/pipeline/camera/object_registration_monitor.h"
#include "slave/pipeline/camera/puncture_cue.h"
#include "slave/pipeline/camera/register_object.h"
#include "slave/pipeline/camera/touch_model.h"
#include "slave/pipeline/manipulator_agreement/manipulator_agreement.h"
#include "slave/scene/scene.h"
#include "slave/vision/observation.h"
#include "slave/vision/tip_and_contour_tracker.h"

namespace palpate {

// Observation of the tip in one image.
struct CameraObservation {
  TipObservation tip;
  cv::Rect search_window;  // of the tip, for overlays [px]
  double duration_us = 0;  // of the tracking
};

// Times per image.
struct StageHistograms {
  LatencyHistogram vision, checks, contact, mechanics, total;
};

// Used by one thread at a time, except See.
class Estimator {
 public:
  // `first`: an image of the object at rest. `p_S_tip_reported`: tip position from the encoders.
  // `place`: where the object may be in it. Throws std::runtime_error or std::invalid_argument
  // naming the cause: see TipAndContourTracker, MakeModel.
  Estimator(const Scene& scene, const Frame& first, std::optional<Eigen::Vector3d> p_S_tip_reported,
            ObjectPlace place = ObjectPlace::kNearPose, Progress* progress = nullptr);
  ~Estimator();

  // Tracks the tip in an image. It shares no data with the functions below, so other threads may
  // call them at the same time.
  [[nodiscard]] CameraObservation See(const Frame& frame) noexcept;
  // The contact in the image of `observation`. Never throws; unknown values are flagged. The
  // estimate is relative to the object at rest: `motion` is the object's motion.
  const ContactEstimate& Estimate(const Frame& frame, const CameraObservation& observation,
                                  const std::optional<EncoderReading>& encoder) noexcept;
  const ContactEstimate& Estimate(const Frame& frame,
                                  const std::optional<EncoderReading>& encoder = {}) noexcept {
    return Estimate(frame, See(frame), encoder);
  }
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
  // The encoders have another origin.
  void ForgetEncoders() noexcept { agreement_.ForgetEncoders(); }

  [[nodiscard]] const ContactEstimate& estimate() const { return estimate_; }
  [[nodiscard]] const CameraObservation& observation() const { return observation_; }
  [[nodiscard]] const TipAndContourTracker& tracker() const { return *tracker_; }
  [[nodiscard]] const CameraView& view() const { return view_; }
  // The plane of the tool's front side: z of S stays 0.
  [[nodiscard]] const CameraView& tool_view() const { return tool_view_; }
  [[nodiscard]] const Registration& registration() const { return registration_; }
  [[nodiscard]] TouchModel& touch() { return *touch_; }
  [[nodiscard]] const TouchModel& touch() const { return *touch_; }
  // See SensingPipeline; of a tool outside its domain from the start.
  [[nodiscard]] std::string_view flag_reason() const;
  // Motion of the object since the first image, S; zero if the camera moves, or if the tool
  // position is unknown.
  [[nodiscard]] const SurfaceMotion& motion() const { return agreement_.motion(); }
  // Distance of the tool from the object in the image of the construction [m]; infinite: the image
  // shows no tip. Before the first Estimate.
  [[nodiscard]] double GapAtStart() noexcept;
  // Pose of the object as the last image shows it, X_SO: a motion of the camera moves it too.
  [[nodiscard]] Eigen::Isometry3d ApparentPose() const;
  // Returns the object's edge in the last image; null: the scene tracks no contour, so the tip is
  // not checked with it.
  [[nodiscard]] const ObjectSighting* sighting() const {
    return edge_ ? &edge_->sighting() : nullptr;
  }
  // The rest outline with the observed motion and indentation [px]; empty: not observed.
  [[nodiscard]] Curve edge_I() const { return edge_ ? edge_->Edge() : Curve(); }
  [[nodiscard]] const StageHistograms& times() const { return times_; }

 private:
  // The tip in the first image's frame.
  struct CompensatedTip {
    Eigen::Vector2d p_I{0, 0};  // [px]
    double sigma = 0;           // including the compensated image motion [px]
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of the same [px^2]
  };
  // The tool in an image, O: its centre, or the tip of a flat one [m], and the unit vector along
  // which it points.
  struct ToolPlace {
    Eigen::Vector2d centre_O{0, 0}, d_O{0, 0};
  };
  // The tool at its contact point, or at the nearest one before.
  struct Press {
    BoundaryPlace place;
    Eigen::Vector2d d_O{0, 0};  // displacement at the beginning of the contact
    ToolPlace tool;
    TouchModel::ToolMotion motion;  // since then
  };

  void PredictIndentation() noexcept;
  void MeasureEdge(const cv::Mat& image) noexcept;
  [[nodiscard]] CompensatedTip CompensateMotion() const noexcept;
  [[nodiscard]] std::optional<CompensatedTip> TipByIndentation() const noexcept;
  void CompareWithEncoders(const CompensatedTip& tip,
                           const std::optional<EncoderReading>& encoder) noexcept;
  // False: the model has no solution.
  bool UpdateContact(const CompensatedTip& tip) noexcept;
  void SetPressForce(const BoundaryPlace& place, const ContactResponse& response,
                     double sigma) noexcept;
  void UpdateLocalModel(const BoundaryPlace& place, const ContactResponse& response) noexcept;
  void DetectPuncture(double depth) noexcept;
  void Examine(const cv::Mat& image, double tip_sigma, bool is_solved) noexcept;
  [[nodiscard]] std::optional<EncoderInnovation> Innovation() const noexcept;
  void ResumeContact() noexcept;
  [[nodiscard]] ToolPlace ToolAt(const Eigen::Vector3d& p_S_tip) const noexcept;
  [[nodiscard]] Eigen::Vector2d TipOf(const BoundaryPlace& place, const Eigen::Vector2d& d_O,
                                      const Eigen::Vector2d& displacement_O) const noexcept;
  [[nodiscard]] Eigen::Vector2d RolledBy(const Eigen::Vector2d& normal_O,
                                         const Eigen::Vector2d& d_O) const noexcept;
  [[nodiscard]] Eigen::Vector2d DirectionAtTouch(const BoundaryPlace& place,
                                                 const ToolPlace& tool) const noexcept;
  [[nodiscard]] double CornerAhead() const noexcept;
  [[nodiscard]] TouchModel::ToolMotion MotionOf(const ToolPlace& tool) const noexcept;
  [[nodiscard]] double DepthOf(const Eigen::Vector2d& indentation_O) const noexcept;
  [[nodiscard]] double GapSigma(const BoundaryPlace& place,
                                const Eigen::Matrix2d& covariance) const noexcept;
  void ForecastIndentation(const BoundaryPlace& place) noexcept;

  CameraView view_;
  CameraView tool_view_;  // the plane of the tool's front side
  std::unique_ptr<TipAndContourTracker> tracker_;
  Registration registration_;
  std::unique_ptr<TouchModel> touch_;
  std::optional<ObjectRegistrationMonitor> edge_;
  ObjectRegistrationMonitor::Bar tool_;  // in the last image
  IndentationForecast forecast_;
  Eigen::Vector2d predicted_O_{0, 0};  // indentation in the last image [px]
  ManipulatorAgreement agreement_;
  Press press_;
  EstimateBuilder rules_;
  double pixel_tolerance_ = 0;  // from the scene [-]
  double plane_error_ = 0;      // see ToolDomain [-]
  double anchor_sigma_ = 0;     // of the tool's end in a template file [m]
  PunctureCue cue_;
  Checks<CameraSample> checks_;
  CameraObservation observation_;  // of the last estimate
  ContactEstimate estimate_;
  double checks_us_ = 0;  // in this image
  StageHistograms times_;
};

}  // namespace palpate
