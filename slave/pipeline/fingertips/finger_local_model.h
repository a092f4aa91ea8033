// The local contact model of a fingertip: the plane it will touch, also before contact, and the
// object's stiffness there.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"
#include "slave/contact/surface_contact.h"
#include "slave/pipeline/fingertips/tactile_body.h"
#include "slave/pipeline/local_model/stiffness_scale.h"
#include "slave/scene/scene.h"

namespace palpate {

// The plane is the tangent plane at the point where the fingertip's sphere would touch the surface
// at rest. Its reference is the position of the pad's apex when the sphere touches, so it is exact
// for every direction of approach. A bonded contact keeps its plane and place until the sphere has
// left; a frictionless one follows the sphere until its centre is inside the object.
//
// The small-strain model determines the shape of the stiffness, and the measured forces at each
// depth its magnitude: the ratio of both at each depth (StiffnessScale) is learnt over tens of
// milliseconds of contact, the slower the less the force exceeds its error, and kept for the next
// contact. Force and slope along the normal are right at the present depth. So is its inclination,
// the ratio of the measured force across the normal to that along it, which the small-strain model
// of a flat disc does not represent.
class FingerLocalModel {
 public:
  explicit FingerLocalModel(const Scene& scene);

  // The estimated contact of the fingertip.
  struct MeasuredForce {
    Eigen::Vector3d force_S{0, 0, 0};  // of the object on it [N]
    double sigma = 0;                  // rms error of the force [N]
  };
  // Sets `model` for the fingertip at `X_SF`; it keeps its plane while the pose is not finite.
  // `measured`: absent without contact or with an unreliable force.
  void Update(TactileBody& body, const Eigen::Isometry3d& X_SO, const Eigen::Isometry3d& X_SF,
              bool in_contact, const std::optional<MeasuredForce>& measured,
              LocalModel* model) noexcept;
  // Updates the local model between samples, quickly and without learning. `model` is unchanged
  // while the stiffness there is not computed yet.
  void Follow(TactileBody& body, const Eigen::Isometry3d& X_SO, const Eigen::Isometry3d& X_SF,
              bool in_contact, LocalModel* model) noexcept;
  // The surface around the fingertip and its compliance at the full depth, and the force-depth
  // curve. Points without a computed stiffness use that of their neighbours. See
  // SensingPipeline::MakePatch.
  bool MakePatch(TactileBody& body, const Eigen::Isometry3d& X_SO, const Eigen::Isometry3d& X_SF,
                 SurfacePatch* patch) noexcept;
  // Returns whether the inclination has changed since the last patch.
  [[nodiscard]] bool HasOutgrownPatch() const noexcept;
  void LearnLaw(TactileBody& body, PatchLaw* law) noexcept;
  // Depth of the fingertip's sphere below the surface at rest [m]; negative outside.
  [[nodiscard]] double depth() const { return depth_; }
  // Contact point on the surface at rest, frame O [m].
  [[nodiscard]] const Eigen::Vector3d& p_O() const { return place_.p_O; }
  // The model's force at this depth along the plane's normal, before it is scaled [N].
  [[nodiscard]] double modelled() const { return modelled_; }
  // Ratio of estimated to modelled force at the present depth [-].
  [[nodiscard]] double force_ratio() const { return scale_.At(depth_).ratio; }
  // Clears plane and learnt values.
  void Forget() noexcept {
    place_.triangle = -1;
    scale_.Forget();
    lean_O_.setZero();
  }

 private:
  void FindPlane(const TactileBody& body, const Eigen::Vector3d& p_O_centre) noexcept;
  void Render(TactileBody& body, const Eigen::Isometry3d& X_SO, const Eigen::Isometry3d& X_SF,
              bool in_contact, const std::optional<MeasuredForce>& measured,
              LocalModel* model) noexcept;
  // Stiffness of `triangle` with `weights` for a contact at `depth`, frame O.
  [[nodiscard]] Eigen::Matrix3d StiffnessOf(TactileBody& body, int triangle,
                                            const Eigen::Vector3d& weights, double depth) noexcept;
  void Size(const Eigen::Matrix3d& K_S, const std::optional<MeasuredForce>& measured,
            LocalModel* model) noexcept;
  void Learn(const MeasuredForce& measured, const Eigen::Vector3d& n_S, double modelled) noexcept;
  // `f_S`: of the model.
  void LearnLean(const MeasuredForce& measured, const Eigen::Vector3d& f_S,
                 const Eigen::Matrix3d& R_SO, const Eigen::Vector3d& n_S) noexcept;

  Material material_;
  ContactLaw law_;
  double radius_, disc_radius_, full_depth_;
  TouchedPlace place_;  // its normal is the normal of the plane
  double depth_ = 0, modelled_ = 0;
  StiffnessScale scale_;
  double lean_rate_;                      // of learning, per sample [-]
  Eigen::Vector3d lean_O_{0, 0, 0};       // tangential force relative to the normal force [-]
  Eigen::Vector3d sent_lean_O_{0, 0, 0};  // of the last patch
};

}  // namespace palpate
