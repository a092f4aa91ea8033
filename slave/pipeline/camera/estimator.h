// One picture in, one felt state out: frame -> observation -> contact -> response. One direction,
// no back and forth; the only place that knows both pictures and forces.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/outline.h"
#include "shared/state/slave_state.h"
#include "shared/state/touch_patch.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/frame_source.h"
#include "slave/contact/boundary_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/indenter/round_indenter.h"
#include "slave/pipeline/arm_watch.h"
#include "slave/pipeline/camera/motion_owner.h"
#include "slave/pipeline/camera/motion_trend.h"
#include "slave/pipeline/camera/object_watch.h"
#include "slave/pipeline/camera/puncture_cue.h"
#include "slave/pipeline/camera/tool_width.h"
#include "slave/pipeline/estimate_rules.h"
#include "slave/pipeline/sense.h"
#include "slave/scene/scene.h"
#include "slave/vision/observation.h"
#include "slave/vision/tip_and_contour_tracker.h"

namespace palpate {

// What the checks of one camera see, and put right, as `check` tells it.
struct CameraLimits {
  static constexpr double kMostScale = 0.02;   // of the object's size in the first picture
  static constexpr double kMostResidual = 2;   // of its outline there, rms [px]
  static constexpr double kToolElsewhere = 1;  // its end from where the manipulator says [px]
  static constexpr double kToolWidth = 0.12;   // by which it may be another one than the scene's
  static constexpr double kArmParts = 0.3;     // tip from where the manipulator says, later on [px]
  static constexpr double kSharpAtRest = 0.30;  // edges of the first picture; 1: sharp
  static constexpr double kSharpness = 0.47;    // the same in parts of the first picture's
  static constexpr double kOverexposed = 1.15;  // of the largest grey level
  static constexpr double kSmallDent = 1.5;     // that needs no confirmation [px]
  // What is put right of the camera's or the object's motion: [px], [rad], [-].
  static constexpr double kMostShift = 40, kMostTurn = 0.06, kMostGrowth = 0.03;
};

// How the rest surface was found in the first picture.
struct Registration {
  bool measured = false;  // false: the scene's pose is taken as it is
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();  // pose in force
  double rms_px = 0;  // of the contour points about the outline
  int points = 0;     // that the fit used
};

// Times per picture.
struct StageHistograms {
  LatencyHistogram vision, checks, contact, mechanics, total;
};

// The part that SetModel replaces as a whole.
struct TouchModel final : Rebuilt {
  [[nodiscard]] const ModelInfo& info() const override { return deformation->info(); }

  BoundaryMesh mesh;
  std::unique_ptr<DeformationModel> deformation;
  std::unique_ptr<RoundIndenter> indenter;  // null: the tool is flat
  std::unique_ptr<BoundaryContact> contact;
  std::unique_ptr<BoundaryContact> probe;  // finds the nearest place of any point
  std::optional<ToolWidth> width;          // of a flat tool
  std::vector<std::uint32_t> held;         // vertices of the outline
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
  const ContactEstimate& Feel(const Frame& frame, const std::optional<ArmWord>& said = {}) noexcept;
  // The contact that the master renders for a tip at p_S_tip [m] now, between pictures too: before
  // it touches, the plane at the nearest place of the outline; that plane stays from where the tip
  // comes in until it has come out.
  LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // The outline around the tip and how it gives way, see Sense::MakePatch.
  bool MakePatch(const Eigen::Vector3d& p_S_tip, TouchPatch* patch) noexcept;
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
  [[nodiscard]] const SurfaceMotion& motion() const { return motion_; }
  // Of the last picture; null: the scene follows no contour, so that nothing checks the tip.
  [[nodiscard]] const ObjectSighting* sighting() const {
    return watch_ ? &watch_->sighting() : nullptr;
  }
  [[nodiscard]] const StageHistograms& times() const { return times_; }

 private:
  void RegisterObject(const Scene& scene);
  void ResumeContact() noexcept;
  // What the object's edge measured goes to the details.
  void TellSighting() noexcept;
  Eigen::Vector2d PutRight(const TipObservation& tip) noexcept;
  [[nodiscard]] bool IsFrozen(const cv::Mat& image) noexcept;
  void AskArm(const ArmWord& said) noexcept;
  void FollowObject(const ArmWord& said) noexcept;
  void LookAtObject(const cv::Mat& image) noexcept;
  [[nodiscard]] double DepthOf(const Eigen::Vector2d& dent_O) const noexcept;
  void LookForPuncture(double depth) noexcept;
  void Touch(const Eigen::Vector3d& p_S_tip) noexcept;
  [[nodiscard]] double GapSigma(const BoundaryPlace& place) const noexcept;
  void ExpectDent(const BoundaryPlace& place) noexcept;
  void Judge(const Eigen::Vector2d& dent_O, double sigma_px) noexcept;
  [[nodiscard]] bool IsDented(const Eigen::Vector2d& dent_O, double sigma_px) const noexcept;
  [[nodiscard]] ContactResponse Respond(const BoundaryPlace& place,
                                        const Eigen::Vector3d& displacement_O) noexcept;
  [[nodiscard]] ContactResponse RespondFlat(const BoundaryPlace& place,
                                            const Eigen::Vector3d& displacement_O) noexcept;
  [[nodiscard]] ToolWidth::Share WidthAt(const BoundaryPlace& place) noexcept;
  bool FieldOf(const BoundaryPlace& place, const Eigen::Vector3d& displacement_O,
               std::vector<Eigen::Vector3d>* field) noexcept;
  [[nodiscard]] Eigen::Matrix3d StiffnessInSlave(const ContactResponse& response) const noexcept;
  [[nodiscard]] double SecantPart(const ContactResponse& response,
                                  const BoundaryPlace& place) const noexcept;
  void UpdateLocalModel(const BoundaryPlace& place, const ContactResponse& response) noexcept;

  CameraView view_;
  std::unique_ptr<TipAndContourTracker> eyes_;
  std::optional<Outline>
      seen_;  // the outline found in the picture, frame O; only for `contour: from-image`
  Registration registration_;
  double rest_sigma_ = 0;  // how well the rest surface is known [m]
  std::unique_ptr<TouchModel> touch_;
  double tool_width_ = 0;  // [m]
  std::optional<ObjectWatch> watch_;
  ArmWatch arm_in_picture_, arm_on_object_;  // one parts where the camera moves, one the object
  MotionOwner owner_;
  MotionTrend trend_;
  SurfaceMotion motion_;
  ObjectWatch::Bar tool_;  // in the last picture
  int dent_element_ = -1;  // whose dent the watch knows; -1: none
  double dent_sigma_ = 0;  // of its displacement as the model tells it, relative [-]
  double dent_depth_ = 0;  // at which a round tool's was taken [m]
  std::vector<Eigen::Vector3d> dent_along_n_, dent_along_t_, dent_along_x_, dent_along_y_;
  Eigen::Vector2d dent_O_{0, 0};  // expected, of the last picture [px]
  double tip_sigma_ = 0;          // with that of the picture's motion [px]
  Eigen::Matrix2d tip_covariance_ = Eigen::Matrix2d::Zero();  // of the same [px^2]
  int unconfirmed_ = 0;  // pictures since the dent was seen last
  int distrust_ = 0;     // pictures until a dent is believed again
  int regained_ = 0;     // pictures until what was lost and is seen again is believed
  cv::Mat last_image_;
  FailedCheck tool_doubt_ = FailedCheck::kNone;  // of the tool in the first picture
  bool is_noisy_ = false;                        // the first picture has noise
  double checks_us_ = 0;                         // of this picture
  ContactLaw law_ = ContactLaw::kBonded;
  BoundaryPlace pressed_place_;          // that the model answered last for the tool
  Eigen::Vector3d pressed_by_{0, 0, 0};  // displacement there, frame O [m]
  EstimateRules rules_;
  PunctureCue cue_;
  const Observation* observation_ = nullptr;
  ContactEstimate felt_;
  StageHistograms times_;
};

}  // namespace palpate
