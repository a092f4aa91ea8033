// One tactile sample in, one felt state out: counts -> force and contact point -> place on the
// object -> deformation (paper B, figure 2). One direction, no back and forth.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/slave_state.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/tactile_frame.h"
#include "slave/pipeline/arm_consistency_check.h"
#include "slave/pipeline/fingertips/finger_contact.h"
#include "slave/pipeline/fingertips/finger_local_model.h"
#include "slave/pipeline/fingertips/tactile_body.h"
#include "slave/scene/scene.h"
#include "slave/tactile/fingertip.h"

namespace palpate {

// What becomes of one fingertip. Frame S, and F where nobody says where the fingertip is.
struct FingerEstimate {
  bool has_pose = false;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_S_apex{0, 0, 0};           // of its pad [m]
  std::optional<Eigen::Vector3d> p_S_contact;  // the place it touches, at rest [m]
  bool in_contact = false;
  std::optional<Eigen::Vector3d> force;  // of the object on the fingertip [N]; nullopt: unknown
  double sigma = 0;                      // rms that its vector may be off by [N]
  Validity validity = Validity::kFailed;
  FailedCheck check = FailedCheck::kNone;
  std::string_view why;  // it is not kValid, one clause; lives on
};

// What turns samples into forces and places.
struct TactileSenses {
  std::shared_ptr<const ForceNetwork> network;  // null: forces stay unknown
  std::shared_ptr<const Localiser> localiser;
};
// As the scene says. Throws std::runtime_error or std::invalid_argument: see LoadForceNetwork,
// MakeLocaliser; a network for samples of another rate; a state to carry that the network
// does not have; a recording without the pac0 or pdc that it takes.
TactileSenses LoadSenses(const Scene& scene);

struct TactileTimes {
  LatencyHistogram tactile, contact, total;
  LatencyHistogram mechanics;  // of samples in which a contact acts
  LatencyHistogram checks;     // part of tactile, all fingertips
};

// One thread at a time. The force felt is the network's, in contact or not; the object's model says
// how the object deforms under the forces of all fingertips that touch it, and how stiff it is for
// the contact that the master renders.
class TactileEstimator {
 public:
  // Throws what LoadSenses and MakeTactileBody throw.
  explicit TactileEstimator(const Scene& scene);
  TactileEstimator(const Scene& scene, TactileSenses senses);
  ~TactileEstimator();

  // `p_S_tip`: where the manipulator says that the hand has its tip; fingertips whose pose the
  // source does not tell follow it. Never throws; allocation-free once every place was touched that
  // is touched (contacts over an area: while their place stays).
  // `arm_lag`: how far the instants of `p_S_tip` and of the sample may be apart [samples], where
  // the arm carries the fingertips whose pose the source tells; nullopt: it does not.
  const ContactEstimate& Estimate(const TactileFrame& frame, const Eigen::Vector3d& p_S_tip,
                                  const std::optional<double>& arm_lag = {}) noexcept;
  // The contact that the master renders for a tip at p_S_tip [m] now, between samples too: that of
  // the first fingertip, carried there as it was when it was last sensed.
  LocalModel LocalAt(const Eigen::Vector3d& p_S_tip) noexcept;
  // The surface around the first fingertip, see SensingPipeline.
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept;
  void LearnLaw(PatchLaw* law) noexcept {
    if (body_) local_touch_->LearnLaw(*body_, law);
  }
  // Precomputes a replacement; may be called from another thread. Null: nothing deforms here.
  [[nodiscard]] static std::unique_ptr<TactileBody> Prepare(const Scene& scene,
                                                            Progress* progress = nullptr);
  // Puts it to work: the object is at rest again, the next sample finds its contacts anew.
  void Adopt(std::unique_ptr<TactileBody> body, const Scene& scene);
  // Rest values, contacts and the object's motion start anew.
  void Reset() noexcept;

  [[nodiscard]] const ContactEstimate& felt() const { return felt_; }
  [[nodiscard]] int finger_count() const { return static_cast<int>(fingertips_.size()); }
  [[nodiscard]] const FingerEstimate& finger(int i) const {
    return fingers_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const FingerTouch& touch(int i) const {
    return fingertips_[static_cast<std::size_t>(i)].touch();
  }
  // Where fingertip `i` meets the object.
  [[nodiscard]] const FingerContact& contact(int i) const {
    return finger_contacts_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const ForceNetwork* network() const { return senses_.network.get(); }
  [[nodiscard]] const Localiser& localiser() const { return *senses_.localiser; }
  // Null: nobody knows where the fingertips are, nothing deforms.
  [[nodiscard]] TactileBody* body() { return body_.get(); }
  [[nodiscard]] const TactileBody* body() const { return body_.get(); }
  [[nodiscard]] const Eigen::Isometry3d& X_SO() const { return X_SO_; }
  // What acts on the object since the last sample: contacts and the model's answers, fingertip by
  // fingertip.
  [[nodiscard]] std::span<const Contact> contacts() const { return contacts_; }
  [[nodiscard]] std::span<const ContactResponse> responses() const { return responses_; }
  // Of the deformation.
  [[nodiscard]] Validity shape_validity() const { return shape_validity_; }
  // Why it is extrapolated, one clause that lives on; may be empty.
  [[nodiscard]] std::string_view shape_doubt() const { return shape_doubt_; }
  // Nodes of body()->surface as they are deformed now, frame S [m]; empty without a body. O(N).
  void DeformedNodes(std::vector<Eigen::Vector3d>* p_S);
  // Triangles of the object's skin. Forces of all fingertips that are felt, whether they or
  // displacements deform the object, each spread over the nodes as the model spreads a load at its
  // place: they add up to minus the forces of those fingertips that have a place on the object;
  // none are told where one of these is unknown. Empty where nothing deforms. Where the model has
  // no answer the shape is that of the last call that had one, with its instant.
  BoundaryShape Shape(bool nodal_forces);
  [[nodiscard]] const TactileTimes& times() const { return times_; }

 private:
  [[nodiscard]] int MissingBefore(const TactileFrame& frame) const noexcept;
  void Place(std::size_t i, const FingerReading& reading, const Eigen::Vector3d& p_S_tip) noexcept;
  [[nodiscard]] bool IsClear(std::size_t i) const noexcept;
  void LetGo() noexcept;
  void UpdateContact(std::size_t i) noexcept;
  void Deform() noexcept;
  [[nodiscard]] bool Respond() noexcept;
  void SeparateHeld() noexcept;
  void ReportFinger(std::size_t i) noexcept;
  void FillShape(BoundaryShape* shape);
  void FlagLostPose(FingerEstimate* finger) const noexcept;
  void CompareStiffness() noexcept;
  void CompareWithEncoders(const EncoderReading& said) noexcept;
  void Flag(std::size_t i, FailedCheck check, std::string_view why) noexcept;
  void ReportTool(const TactileFrame& frame, const Eigen::Vector3d& p_S_tip) noexcept;

  std::vector<Finger> scene_fingers_;
  bool has_poses_file_;  // which alone tells where fingertips are
  Eigen::Isometry3d X_SO_;
  Eigen::Vector3d p_S_home_;
  double press_depth_;     // the scene's [m]
  double pose_tolerance_;  // likewise [rad]
  double period_;          // of the samples [s]
  double radius_;
  TactileSenses senses_;
  std::vector<Fingertip> fingertips_;
  std::vector<FingerContact> finger_contacts_;
  std::array<FingerEstimate, kMaxFingers> fingers_;
  std::unique_ptr<TactileBody> body_;
  std::optional<FingerLocalModel> local_touch_;
  ArmConsistencyCheck arm_;
  int arm_doubts_ = 0;             // samples for which it is doubted yet
  std::vector<Contact> contacts_;  // of the fingertips in acting_
  std::vector<ContactResponse> responses_;
  std::vector<std::size_t> acting_;
  bool at_rest_ = true;
  Validity shape_validity_ = Validity::kValid;
  std::string_view shape_doubt_;
  BoundaryShape last_shape_;  // that the model had an answer for; without nodes: none
  bool was_known_ = false;
  ContactEstimate felt_;
  TactileTimes times_;
};

}  // namespace palpate
