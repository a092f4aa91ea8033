// Computes one contact estimate from one tactile sample: counts -> force and contact point -> point
// on the object -> deformation (paper B, figure 2).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/tactile_frame.h"
#include "slave/checks/fingertips/fingertip_checks.h"
#include "slave/pipeline/fingertips/finger_local_model.h"
#include "slave/pipeline/fingertips/tactile_body.h"
#include "slave/pipeline/fingertips/touched_object.h"
#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"
#include "slave/scene/scene.h"
#include "slave/tactile/fingertip.h"

namespace palpate {

// Result for one fingertip. Frame S, or F if the pose of the fingertip is unknown.
struct FingerEstimate : Verdict {
  bool has_pose = false;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_S_apex{0, 0, 0};           // of its pad [m]
  std::optional<double> depth;                 // below the surface at rest [m]; nullopt: unknown
  std::optional<Eigen::Vector3d> p_S_contact;  // contact point on the object at rest [m]
  bool in_contact = false;
  std::optional<Eigen::Vector3d> force;  // of the object on the fingertip [N]; nullopt: unknown
  double sigma = 0;                      // rms error of the force vector [N]
};

// Network and localiser, which turn samples into forces and contact points.
struct TactileSenses {
  std::shared_ptr<const ForceNetwork> network;  // null: forces stay unknown
  std::shared_ptr<const Localiser> localiser;
};
// Loads the senses of a scene. Throws std::runtime_error or std::invalid_argument: see
// LoadForceNetwork, MakeLocaliser; a network for another sample rate; a carried state that the
// network does not have; a recording without the pac0 or pdc that it needs.
TactileSenses LoadSenses(const Scene& scene);

struct TactileTimes {
  LatencyHistogram tactile, contact, total;
  LatencyHistogram mechanics;  // of samples in which a contact acts
  LatencyHistogram checks;     // and repair of the signals, all fingertips
};

// Used by one thread at a time. The force is the network's, in contact or not. The object's model
// computes its deformation under the forces of all fingertips in contact, and its stiffness for the
// local contact model.
class TactileEstimator {
 public:
  // Throws the exceptions of LoadSenses and MakeTactileBody.
  explicit TactileEstimator(const Scene& scene);
  TactileEstimator(const Scene& scene, TactileSenses senses);

  // `p_S_tip`: tip position from the encoders; fingertips without a pose from the source follow it.
  // Never throws; allocation-free once every contact point was visited (contacts over an area:
  // while they stay). `arm_lag`: largest time between `p_S_tip` and the sample [samples], if the
  // manipulator carries the fingertips whose pose the source provides; nullopt: it does not.
  const ContactEstimate& Estimate(const TactileFrame& frame, const Eigen::Vector3d& p_S_tip,
                                  const std::optional<double>& arm_lag = {}) noexcept;
  // The plane that the master renders for a tip at p_S_tip [m] now, also between samples: that of
  // the first fingertip in its last orientation.
  LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // The surface around the first fingertip, see SensingPipeline.
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept;
  [[nodiscard]] bool HasOutgrownPatch() const noexcept { return local_touch_->HasOutgrownPatch(); }
  void LearnLaw(PatchLaw* law) noexcept {
    if (body() != nullptr) local_touch_->LearnLaw(*body(), law);
  }
  // Precomputes a replacement; may be called from another thread. Null: no deformable object.
  [[nodiscard]] static std::unique_ptr<TactileBody> Prepare(const Scene& scene,
                                                            Progress* progress = nullptr);
  // Activates it: the object is at rest again, and the next sample finds its contacts again.
  void Adopt(std::unique_ptr<TactileBody> body, const Scene& scene);
  // Resets baseline, contacts and the object's motion.
  void Reset() noexcept;
  // The encoders have another origin.
  void ForgetEncoders() noexcept { arm_.Reset(); }

  [[nodiscard]] const ContactEstimate& estimate() const { return estimate_; }
  [[nodiscard]] int finger_count() const { return static_cast<int>(fingertips_.size()); }
  [[nodiscard]] const FingerEstimate& finger(int i) const {
    return fingers_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const FingerTouch& touch(int i) const {
    return fingertips_[static_cast<std::size_t>(i)].touch();
  }
  [[nodiscard]] const ForceNetwork* network() const { return senses_.network.get(); }
  [[nodiscard]] const Localiser& localiser() const { return *senses_.localiser; }
  [[nodiscard]] const TouchedObject& object() const { return object_; }
  // Null: the poses of the fingertips are unknown, and the object is not deformed.
  [[nodiscard]] TactileBody* body() const { return object_.body(); }
  // Triangles of the object's surface. The estimated forces of all fingertips, each spread over the
  // nodes as the model spreads a load; they add up to minus the forces of the fingertips in contact
  // with the object. No forces if one of them is unknown. Empty if the object is not deformed. If
  // the model has no solution, the shape and time of the last one.
  BoundaryShape Shape(const ShapeParts& parts);
  [[nodiscard]] const TactileTimes& times() const { return times_; }

 private:
  struct FingerChecks {
    Checks<FingertipSample> checks = MakeFingertipChecks();
    Consistency consistency{kConsistencyWindow};
  };
  // [samples]: nearly the window of the paper's networks.
  static constexpr int kConsistencyWindow = 15;

  [[nodiscard]] int MissingBefore(const TactileFrame& frame) const noexcept;
  // Pose, force and contact point of each fingertip.
  void Observe(const TactileFrame& frame, const Eigen::Vector3d& p_S_tip) noexcept;
  void Locate(std::size_t i, const FingerReading& reading, const Eigen::Vector3d& p_S_tip) noexcept;
  // Distance of the first fingertip from its encoder pose [m]; nullopt: not compared.
  std::optional<double> EncoderError(const TactileFrame& frame, const Eigen::Vector3d& p_S_tip,
                                     const std::optional<double>& arm_lag) noexcept;
  void EstimateFinger(std::size_t i, const std::optional<double>& encoder_error) noexcept;
  void CheckFinger(std::size_t i, const std::optional<double>& encoder_error) noexcept;
  void EstimateTool(const TactileFrame& frame, const Eigen::Vector3d& p_S_tip) noexcept;
  void UpdateLocalModel() noexcept;
  void EstimateMoment() noexcept;
  // Pose of the first fingertip if its tip were at p_S_tip [m]; nullopt: no force is rendered.
  [[nodiscard]] std::optional<Eigen::Isometry3d> PoseAt(const Eigen::Vector3d& p_S_tip) const;

  Tactile tactile_;  // of the scene
  Eigen::Vector3d p_S_home_;
  double press_depth_;  // the scene's [m]
  TactileSenses senses_;
  std::vector<Fingertip> fingertips_;
  std::vector<FingerChecks> checks_;
  std::array<FingerEstimate, kMaxFingers> fingers_;
  TouchedObject object_;
  std::optional<FingerLocalModel> local_touch_;
  ArmConsistencyCheck arm_;
  BoundaryShape last_shape_;  // of the last solution; without nodes: none
  bool was_known_ = false;
  ContactEstimate estimate_;
  TactileTimes times_;
};

}  // namespace palpate
